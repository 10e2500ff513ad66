// A model that can be turned, cut, taken apart and asked. The page holds one `script` of JSON inside the
// container: the file as base64, and what lies over it.

import { bytesOf, readGlb } from './glb.js';
import { Cut } from './cut.js';
import { Model, lineMaterial } from './model.js';
import { pressedOf, raysOf } from './overlays.js';
import { button, checkbox, choice, facts, make, slider, tree } from './panel.js';
import { Stage, VIEWS, boxOf } from './stage.js';

const AXES = [['', 'nothing'], ['x', 'across x'], ['y', 'across y'], ['z', 'across z']];

class Viewer {
  constructor(container) {
    const data = JSON.parse(container.querySelector('script').textContent);
    this.data = data;
    this.canvas = make('canvas', {
      tabindex: 0, role: 'application', 'aria-label': `${data.title}, a model to turn`,
      'aria-describedby': 'viewer-keys',
    });
    this.tree = make('div', { class: 'viewer-tree' });
    this.told = make('div', { class: 'viewer-told', role: 'status' });
    this.tools = make('div', { class: 'viewer-tools' });
    const keys = 'Drag to turn, click a body to ask. With keys: arrows turn, + and - come nearer, Home starts again.';
    container.append(
      this.tools,
      make('div', { class: 'viewer-stage' }, this.canvas, this.tree),
      make('p', { id: 'viewer-keys', class: 'quiet' }, keys),
      this.told,
    );
    container.hidden = false;
    this.stage = new Stage(this.canvas);
    this.cut = new Cut(this.stage.scene);
    this.edges = lineMaterial(this.cut.planes);
    this.outline = lineMaterial([]);
    this.glb = readGlb(bytesOf(data.glb));
    this.state = { axis: '', apart: 0, isEdged: true };
    this.colors();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.colors());
    this.canvas.addEventListener('pointerdown', (event) => (this.pressed = [event.clientX, event.clientY]));
    this.canvas.addEventListener('click', (event) => this.click(event));
    this.open(0);
    this.stage.draw();
    performance.mark('fabkit-first-frame');
    // Edges take longer than the first picture should.
    setTimeout(() => this.edge(this.state.isEdged));
  }

  /** Shows one scene of the file. */
  open(scene) {
    if (this.model) this.stage.scene.remove(this.model.world);
    this.model = new Model(this.glb, scene, this.cut.planes);
    this.stage.scene.add(this.model.world);
    this.model.explode(1);
    const apart = boxOf(this.model.solids);
    this.model.explode(0);
    this.box = boxOf(this.model.solids);
    this.chosen = undefined;
    this.told.replaceChildren();
    this.cut.of(this.model, this.outline, 1.2 * apart.union(this.box).max.distanceTo(apart.min));
    this.canMove = this.model.solids.some(({ apart }) => apart.lengthSq() > 0);
    this.state.apart = 0;
    this.lay(scene);
    this.tree.replaceChildren(...tree(this.model.bodies, (b, on) => this.show(b, on), (b) => this.choose(b)));
    this.controls(scene);
    this.cutAt('');
    this.stage.frame(this.box);
  }

  controls(scene) {
    this.range = slider('at', { step: 0.05, 'aria-label': 'where the cut is, mm' }, () => this.cutAgain());
    this.place = make('output', {});
    const apart = slider('Apart', { min: 0, max: 1, step: 0.01, value: 0 }, (share) => this.explode(share));
    const edges = checkbox('Edges', this.state.isEdged, (isOn) => this.edge(isOn));
    const overlays = Object.entries(this.over).map(
      ([name, { title }]) => checkbox(title, false, (isOn) => this.overlay(name, isOn)).label,
    );
    const scenes = this.glb.document.scenes.map(({ name }, number) => [number, name]);
    const which = choice('Show', scenes, (number) => this.open(Number(number)));
    which.querySelector('select').selectedIndex = scene;
    const looks = Object.keys(VIEWS).map((name) => button(name, () => this.stage.look(name)));
    const axis = choice('Cut', AXES, (value) => this.cutAt(value));
    const group = (label, ...content) => make('div', { role: 'group', 'aria-label': label }, ...content);
    this.tools.replaceChildren(
      ...(scenes.length > 1 ? [which] : []),
      group('look from', ...looks),
      group('cut', axis, this.range.label, this.place),
      ...(this.canMove ? [apart.label] : []),
      group('draw', edges.label, ...overlays),
    );
  }

  /** What lies over the sensor as it is used, by name, with its title. */
  lay(scene) {
    const { rays, pressed } = this.data;
    this.over = {};
    if (scene !== 0) return;
    if (rays) this.over.rays = { ...rays, make: () => raysOf(rays, this.cut.planes) };
    if (pressed) this.over.pressed = { ...pressed, make: () => pressedOf(pressed, this.cut.planes) };
  }

  overlay(name, isOn) {
    const over = this.over[name];
    if (!over.object) this.model.root.add((over.object = over.make()));
    over.isOn = isOn;
    this.lie(name);
    for (const body of this.model.bodies) {
      if (!over.instead_of?.includes(body.name)) continue;
      body.box.checked = !isOn;
      body.box.dispatchEvent(new Event('change'));
    }
    this.stage.redraw();
  }

  /** What lies over the sensor makes sense on the whole sensor alone. */
  lie(name) {
    const { object, isOn } = this.over[name];
    if (object) object.visible = isOn && this.state.apart === 0;
  }

  show(body, isOn) {
    body.object.visible = isOn;
    this.cutAgain();
  }

  choose(body) {
    if (this.chosen) this.mark(this.chosen, false);
    this.chosen = this.chosen === body ? undefined : body;
    if (this.chosen) this.mark(body, true);
    this.told.replaceChildren(...(this.chosen ? facts(body) : []));
    this.stage.redraw();
  }

  mark(body, isOn) {
    body.material.emissive.setHex(isOn ? 0x2a5f9e : 0);
    body.button.setAttribute('aria-pressed', isOn);
  }

  click(event) {
    const [x, y] = this.pressed ?? [event.clientX, event.clientY];
    // A turn is no click.
    if (Math.hypot(event.clientX - x, event.clientY - y) > 4) return;
    const visible = this.model.solids.filter(({ body }) => body.object.visible);
    const mesh = this.stage.pick(event, visible.map((solid) => solid.mesh), this.cut.planes);
    const body = visible.find((solid) => solid.mesh === mesh)?.body ?? this.chosen;
    if (body) this.choose(body);
  }

  /** Cuts across an axis through the middle, or not at all. */
  cutAt(axis) {
    this.state.axis = axis;
    const { range } = this.range;
    range.disabled = axis === '';
    this.range.label.hidden = axis === '';
    if (axis !== '') {
      const [least, most] = [this.box.min[axis], this.box.max[axis]];
      Object.assign(range, { min: least.toFixed(2), max: most.toFixed(2) });
      range.value = axis === 'z' ? (least + most) / 2 : 0;
    }
    this.cutAgain();
  }

  cutAgain() {
    const { axis } = this.state;
    const place = Number(this.range.range.value);
    this.cut.at(axis === '' ? undefined : axis, place);
    this.place.textContent = axis === '' ? '' : `${axis} = ${place.toFixed(2)} mm`;
    this.stage.redraw();
  }

  explode(share) {
    this.state.apart = share;
    this.model.explode(share);
    for (const name of Object.keys(this.over)) this.lie(name);
    this.stage.frame(boxOf(this.model.solids));
    this.cutAgain();
  }

  edge(isOn) {
    this.state.isEdged = isOn;
    this.model.showEdges(isOn, this.edges);
    this.stage.redraw();
  }

  colors() {
    for (const material of [this.edges, this.outline]) material.color.copy(this.stage.color('--edge'));
    this.stage.redraw();
  }
}

for (const container of document.querySelectorAll('.viewer')) {
  try {
    new Viewer(container);
    const nav = document.querySelector('nav');
    nav?.prepend(make('a', { href: `#${container.id}` }, 'Model'));
  } catch (error) {
    // A browser without WebGL: pictures and tables say the same.
    container.hidden = true;
    console.warn(error);
  }
}
