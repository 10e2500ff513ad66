// The canvas: camera, light, turning with pointer, fingers and keys. A frame is drawn only when something changed.

import {
  Box3, Color, DirectionalLight, DoubleSide, FrontSide, HemisphereLight, OrthographicCamera, Raycaster, Scene,
  Sphere, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

/** Where one looks from; the first one is that of fabkit's pictures. */
export const VIEWS = {
  Oblique: [1, -1, 1], Front: [0, -1, 0], Right: [1, 0, 0], Top: [0, -1e-4, 1], Bottom: [0, -1e-4, -1],
};
const KEY_TURN = Math.PI / 24;
const KEY_ZOOM = 1.15;
const FLIGHT_MS = 350;

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, stencil: true, alpha: true });
    this.renderer.localClippingEnabled = true;
    // Asking makes the first frame wait for the compiler.
    this.renderer.debug.checkShaderErrors = false;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.scene = new Scene();
    this.camera = new OrthographicCamera();
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(...VIEWS.Oblique);
    const lamp = new DirectionalLight(0xffffff, 2.2);
    lamp.position.set(-0.5, 0.8, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x9a948c, 1.6));
    this.scene.children[1].position.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    // Wheels and fingers still scroll the page, until somebody works with the model.
    this.controls.enableZoom = false;
    canvas.style.touchAction = 'pan-y';
    canvas.addEventListener('focus', () => (this.controls.enableZoom = true));
    canvas.addEventListener('blur', () => (this.controls.enableZoom = false));
    canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener('keydown', (event) => this.key(event));
    this.controls.addEventListener('change', () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Keeps all of a box in sight, from where one looks now. */
  frame(box) {
    this.box = box;
    this.sphere = box.getBoundingSphere(new Sphere());
    const way = new Vector3().subVectors(this.camera.position, this.controls.target).normalize();
    this.controls.target.copy(this.sphere.center);
    this.camera.position.copy(this.sphere.center).addScaledVector(way, 4 * this.sphere.radius);
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.resize();
  }

  /** From a side; flies there unless the reader's machine asks for less motion. */
  look(name, flies = true) {
    const target = this.sphere.center;
    const goal = new Vector3(...VIEWS[name]).normalize();
    const start = new Vector3().subVectors(this.camera.position, target).normalize();
    const place = (share) => {
      const way = start.clone().lerp(goal, share);
      if (way.lengthSq() < 1e-6) way.copy(goal);
      this.camera.position.copy(target).addScaledVector(way.normalize(), 4 * this.sphere.radius);
      this.controls.target.copy(target);
      this.camera.zoom = this.camera.zoom + share * (1 - this.camera.zoom);
      this.controls.update();
      this.camera.updateMatrixWorld();
      this.resize();
    };
    if (!flies || matchMedia('(prefers-reduced-motion: reduce)').matches) return place(1);
    const begin = performance.now();
    const step = (now) => {
      const share = Math.min(1, Math.max(0, (now - begin) / FLIGHT_MS));
      place(share * share * (3 - 2 * share));
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!this.sphere || width === 0 || height === 0) return;
    const drawn = this.renderer.getSize(new Vector2());
    if (drawn.x !== width || drawn.y !== height) this.renderer.setSize(width, height, false);
    const half = 1.1 * Math.max(...this.halves(width / height));
    Object.assign(this.camera, {
      left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half,
      near: 0, far: 8 * this.sphere.radius,
    });
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  /** How far the box reaches from the middle of the picture: up, and across as it would be up. */
  halves(aspect) {
    const { min, max } = this.box;
    const inverse = this.camera.matrixWorldInverse.copy(this.camera.matrixWorld).invert();
    const middle = this.sphere.center.clone().applyMatrix4(inverse);
    const corners = Array.from({ length: 8 }, (_, i) => new Vector3(
      i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z,
    ).applyMatrix4(inverse).sub(middle));
    return corners.map(({ x, y }) => Math.max(Math.abs(y), Math.abs(x) / aspect));
  }

  redraw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.isDue = false;
    this.renderer.render(this.scene, this.camera);
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zooms = { '+': KEY_ZOOM, '=': KEY_ZOOM, '-': 1 / KEY_ZOOM };
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (turns[event.key]) {
      const [around, down] = turns[event.key];
      const way = new Vector3().subVectors(this.camera.position, this.controls.target);
      const [radius, azimuth] = [way.length(), Math.atan2(way.y, way.x) + around * KEY_TURN];
      const polar = Math.acos(way.z / radius) + down * KEY_TURN;
      const safe = Math.min(Math.PI - 1e-4, Math.max(1e-4, polar));
      way.set(Math.sin(safe) * Math.cos(azimuth), Math.sin(safe) * Math.sin(azimuth), Math.cos(safe));
      this.camera.position.copy(this.controls.target).addScaledVector(way, radius);
      this.controls.update();
    } else if (zooms[event.key]) {
      this.camera.zoom *= zooms[event.key];
      this.camera.updateProjectionMatrix();
      this.redraw();
    } else if (event.key === 'Home') {
      this.look('Oblique');
    } else {
      return;
    }
    event.preventDefault();
  }

  /** What a place of the canvas shows: the first of some objects that the plane has not cut away. */
  pick(event, objects, planes) {
    const sides = (side) => objects.forEach(({ material }) => (material.side = side));
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((event.clientX - left) / width, (event.clientY - top) / height);
    const caster = new Raycaster();
    caster.setFromCamera(at.set(2 * at.x - 1, 1 - 2 * at.y), this.camera);
    const isKept = ({ point }) => planes.every((plane) => plane.distanceToPoint(point) >= 0);
    // Through a cut one looks at a body from within.
    sides(DoubleSide);
    const found = caster.intersectObjects(objects, false).find(isKept)?.object;
    sides(FrontSide);
    return found;
  }

  /** A colour of the page's style, which dark mode changes. */
  color(name) {
    return new Color(getComputedStyle(this.canvas).getPropertyValue(name).trim());
  }
}

/** The box around visible bodies, or around all where none is. */
export function boxOf(solids) {
  const box = new Box3();
  for (const { mesh } of solids) {
    mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
    box.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrixWorld));
  }
  return box;
}
