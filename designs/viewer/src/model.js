// Bodies as three.js draws them.

import {
  BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshLambertMaterial,
} from 'three';

const METRES = 1e-3;

/** One scene of a file: an assembly in millimetres with z up, and its bodies in the file's order. */
export class Model {
  constructor(glb, scene, clippingPlanes) {
    this.glb = glb;
    this.clippingPlanes = clippingPlanes;
    this.geometries = new Map();
    const number = glb.document.scenes[scene].nodes[0];
    const { children, extras } = glb.document.nodes[number];
    this.extras = extras;
    // glTF has metres and y up; here are millimetres and z up.
    this.world = new Group();
    this.world.rotation.x = Math.PI / 2;
    this.world.scale.setScalar(1 / METRES);
    this.root = this.placed(number);
    this.world.add(this.root);
    this.bodies = children.map((child) => this.body(child));
    for (const body of this.bodies) this.root.add(body.object);
    this.solids = this.bodies.flatMap((body) => body.solids);
    this.world.updateMatrixWorld(true);
  }

  /** Moves all bodies apart: 0 is where they belong, 1 as far as the design spreads them. */
  explode(share) {
    for (const { mesh, from, apart } of this.solids) {
      mesh.position.copy(from).addScaledVector(apart, share);
    }
    this.world.updateMatrixWorld(true);
  }

  showEdges(isOn, material) {
    for (const solid of this.solids) {
      solid.edges ??= isOn ? edgesOf(solid.mesh, material) : undefined;
      if (solid.edges) solid.edges.visible = isOn;
    }
  }

  placed(number, object = new Group()) {
    const { translation, rotation, scale, name } = this.glb.document.nodes[number];
    if (translation) object.position.fromArray(translation);
    if (rotation) object.quaternion.fromArray(rotation);
    if (scale) object.scale.fromArray(scale);
    object.name = name;
    return object;
  }

  body(number) {
    const { name, extras, mesh, children } = this.glb.document.nodes[number];
    const nodes = mesh === undefined ? children : [number];
    const body = { name, extras, solids: [] };
    const first = this.glb.document.nodes[nodes[0]].mesh;
    body.material = this.material(this.glb.document.meshes[first].primitives[0].material);
    body.object = new Group();
    for (const node of nodes) {
      const primitive = this.glb.document.meshes[this.glb.document.nodes[node].mesh].primitives[0];
      const mesh = this.placed(node, new Mesh(this.geometry(primitive), body.material));
      const from = mesh.position.clone();
      const apart = from.clone().fromArray(this.glb.moves.get(node) ?? [0, 0, 0]);
      body.solids.push({ body, mesh, from, apart });
      body.object.add(mesh);
    }
    return body;
  }

  geometry({ attributes, indices }) {
    if (!this.geometries.has(indices)) {
      const geometry = new BufferGeometry();
      const vectors = (accessor) => new BufferAttribute(this.glb.arrays(accessor), 3);
      geometry.setAttribute('position', vectors(attributes.POSITION));
      geometry.setAttribute('normal', vectors(attributes.NORMAL));
      geometry.setIndex(new BufferAttribute(this.glb.arrays(indices), 1));
      this.geometries.set(indices, geometry);
    }
    return this.geometries.get(indices);
  }

  material(number) {
    const [r, g, b, opacity] =
      this.glb.document.materials[number].pbrMetallicRoughness.baseColorFactor;
    const isClear = opacity < 1;
    const material = new MeshLambertMaterial({
      opacity, transparent: isClear, depthWrite: !isClear, clippingPlanes: this.clippingPlanes,
      // So that edges lie before faces.
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    material.color.setRGB(r, g, b);
    return material;
  }
}

/** Lines where vertices are divided: fabkit divides them exactly at the edges of exact surfaces. */
function edgesOf(mesh, material) {
  const index = mesh.geometry.index.array;
  const count = mesh.geometry.attributes.position.count;
  const sides = new Map();
  for (let i = 0; i < index.length; i++) {
    const [a, b] = [index[i], index[i % 3 === 2 ? i - 2 : i + 1]];
    const key = Math.min(a, b) * count + Math.max(a, b);
    sides.set(key, (sides.get(key) ?? 0) + 1);
  }
  const lines = [];
  for (const [key, uses] of sides) if (uses === 1) lines.push(Math.floor(key / count), key % count);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', mesh.geometry.attributes.position);
  geometry.setIndex(lines);
  const edges = new LineSegments(geometry, material);
  edges.raycast = () => {};
  mesh.add(edges);
  return edges;
}

/** What edges and cuts are drawn with. */
export function lineMaterial(clippingPlanes) {
  return new LineBasicMaterial({ transparent: true, opacity: 0.55, clippingPlanes });
}
