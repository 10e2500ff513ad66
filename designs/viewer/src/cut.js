// The plane that cuts, and what closes the bodies that it cuts: solid faces with dark outlines.
//
// A pixel of the plane lies in a closed body if behind it more back faces than front faces are kept: the stencil
// buffer counts them, body by body, and a face is drawn where something is left.

import {
  AlwaysStencilFunc, BackSide, Box3, BufferAttribute, BufferGeometry, DecrementWrapStencilOp, DoubleSide,
  FrontSide, IncrementWrapStencilOp, LineSegments, Matrix4, Mesh, MeshBasicMaterial, NotEqualStencilFunc,
  Plane, PlaneGeometry, ReplaceStencilOp, Vector3,
} from 'three';

const AWAY = { x: new Vector3(-1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, -1) };

export class Cut {
  constructor(scene) {
    this.scene = scene;
    this.planes = [];
    this.plane = new Plane();
    const counting = (side, op) => new MeshBasicMaterial({
      side, colorWrite: false, depthWrite: false, depthTest: false, clippingPlanes: [this.plane],
      stencilWrite: true, stencilFunc: AlwaysStencilFunc, stencilFail: op, stencilZFail: op, stencilZPass: op,
    });
    this.counters = [
      counting(BackSide, IncrementWrapStencilOp), counting(FrontSide, DecrementWrapStencilOp),
    ];
    this.caps = [];
  }

  /** Takes another model, without cutting it yet. */
  of(model, outline, size) {
    for (const { face, lines } of this.caps) this.scene.remove(face, lines);
    this.caps = [];
    this.model = model;
    this.outline = outline;
    this.size = size;
  }

  /** Cuts across an axis at a place, mm; `undefined` for the axis cuts nothing. */
  at(axis, place) {
    this.isOn = axis !== undefined;
    if (this.isOn) {
      this.plane.normal.copy(AWAY[axis]);
      this.plane.constant = -place * AWAY[axis][axis];
      if (this.caps.length === 0) this.caps = this.model.solids.map((solid, i) => this.cap(solid, i));
    }
    // The same list all the time: materials hold on to it.
    this.planes.splice(0, this.planes.length, ...(this.isOn ? [this.plane] : []));
    for (const cap of this.caps) this.update(cap);
  }

  cap(solid, number) {
    const counters = this.counters.map((material) => {
      const counter = new Mesh(solid.mesh.geometry, material);
      counter.renderOrder = 2 * number + 1;
      counter.raycast = () => {};
      solid.mesh.add(counter);
      return counter;
    });
    const face = new Mesh(new PlaneGeometry(this.size, this.size), new MeshBasicMaterial({
      side: DoubleSide, stencilWrite: true, stencilRef: 0, stencilFunc: NotEqualStencilFunc,
      stencilFail: ReplaceStencilOp, stencilZFail: ReplaceStencilOp, stencilZPass: ReplaceStencilOp,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    }));
    face.renderOrder = 2 * number + 2;
    face.onAfterRender = (renderer) => renderer.clearStencil();
    const lines = new LineSegments(new BufferGeometry(), this.outline);
    for (const object of [face, lines]) {
      object.raycast = () => {};
      this.scene.add(object);
    }
    return { solid, counters, face, lines };
  }

  update({ solid, counters, face, lines }) {
    const { mesh, body } = solid;
    mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
    const box = new Box3().copy(mesh.geometry.boundingBox).applyMatrix4(mesh.matrixWorld);
    const isCut = this.isOn && body.object.visible && this.plane.intersectsBox(box);
    for (const object of [...counters, face, lines]) object.visible = isCut;
    if (!isCut) return;
    face.material.color.copy(body.material.color);
    this.plane.coplanarPoint(face.position);
    // About the body, so that a small face does for a body far off.
    this.plane.projectPoint(box.getCenter(new Vector3()), face.position);
    face.lookAt(new Vector3().subVectors(face.position, this.plane.normal));
    lines.geometry.dispose();
    lines.geometry = outlineOf(mesh, this.plane);
  }
}

/** Where a plane cuts the triangles of a mesh: lines in the scene's frame. */
function outlineOf(mesh, plane) {
  const local = plane.clone().applyMatrix4(new Matrix4().copy(mesh.matrixWorld).invert());
  const { x, y, z } = local.normal;
  const at = mesh.geometry.attributes.position.array;
  const index = mesh.geometry.index.array;
  const heights = new Float32Array(at.length / 3);
  for (let i = 0; i < heights.length; i++) {
    heights[i] = x * at[3 * i] + y * at[3 * i + 1] + z * at[3 * i + 2] + local.constant;
  }
  const points = [];
  for (let i = 0; i < index.length; i += 3) {
    for (let side = 0; side < 3; side++) {
      const [a, b] = [index[i + side], index[i + ((side + 1) % 3)]];
      if (heights[a] < 0 === heights[b] < 0) continue;
      const share = heights[a] / (heights[a] - heights[b]);
      for (let axis = 0; axis < 3; axis++) {
        points.push(at[3 * a + axis] + share * (at[3 * b + axis] - at[3 * a + axis]));
      }
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  return geometry.applyMatrix4(mesh.matrixWorld);
}
