// What lies over the model: rays of the camera, and the surface pressed in with its depth as colour.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial,
  SRGBColorSpace,
} from 'three';
import { bytesOf } from './glb.js';

const floats = (base64) => new BufferAttribute(new Float32Array(bytesOf(base64).buffer), 3);

/** From the screen's numbers to light, in which three.js calculates. */
const light = (rgb) => new Color().setRGB(...rgb.map((part) => part / 255), SRGBColorSpace).toArray();

/** Lines of rays in the sensor's frame, mm. */
export function raysOf({ rays }, clippingPlanes) {
  const [points, colors] = [[], []];
  for (const { color, path_mm } of rays) {
    for (let i = 1; i < path_mm.length; i++) {
      points.push(...path_mm[i - 1], ...path_mm[i]);
      colors.push(...light(color), ...light(color));
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute('color', new BufferAttribute(new Float32Array(colors), 3));
  // Over all bodies, or nobody would see rays inside a shell.
  const material = new LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true, clippingPlanes });
  const lines = new LineSegments(geometry, material);
  lines.renderOrder = 1e6;
  return lines;
}

/** The surface while something presses. */
export function pressedOf({ positions, normals, colors, triangles }, clippingPlanes) {
  const bytes = bytesOf(colors);
  const table = Float32Array.from({ length: 256 }, (_, value) => light([value, 0, 0])[0]);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', floats(positions));
  geometry.setAttribute('normal', floats(normals));
  geometry.setAttribute('color', new BufferAttribute(Float32Array.from(bytes, (value) => table[value]), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytesOf(triangles).buffer), 1));
  return new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, clippingPlanes }));
}
