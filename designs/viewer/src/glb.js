// Reads the GLB files that fabkit writes: one buffer, 32-bit vectors, 16- or 32-bit indices, bodies right
// below a root, and at most one animation that moves nodes from here to there. Nothing else is in them.

const KINDS = { 5126: Float32Array, 5125: Uint32Array, 5123: Uint16Array };

/** Bytes from base64, without a request, which `fetch` would make. */
export function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** The document with `arrays(accessor)`, which gives numbers without copying them. */
export function readGlb(bytes) {
  const view = new DataView(bytes.buffer);
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  const arrays = (number) => {
    const accessor = document.accessors[number];
    const place = document.bufferViews[accessor.bufferView];
    const start = 28 + length + (place.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const count = accessor.count * (accessor.type === 'VEC3' ? 3 : 1);
    return new KINDS[accessor.componentType](bytes.buffer, start, count);
  };
  return { document, arrays, moves: moves(document, arrays) };
}

/** How far each node moves when all is taken apart: by the node's number, mm. */
function moves(document, arrays) {
  const found = new Map();
  for (const { channels, samplers } of document.animations ?? []) {
    for (const { sampler, target } of channels) {
      const ends = arrays(samplers[sampler].output);
      found.set(target.node, [0, 1, 2].map((axis) => ends[3 + axis] - ends[axis]));
    }
  }
  return found;
}
