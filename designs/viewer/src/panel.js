// Everything beside the canvas: plain HTML controls, each with a label.

const GROUPS = { part: 'Parts', layer: 'Layers', component: 'Bought' };

/** An element with attributes, and what is in it; keys that begin with `on` are listeners. */
export function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, '');
    else if (value !== false && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...content);
  return element;
}

export const button = (text, onclick, attributes) =>
  make('button', { type: 'button', onclick, ...attributes }, text);

export function checkbox(text, checked, change) {
  const input = make('input', { type: 'checkbox', onchange: () => change(input.checked) });
  input.checked = checked;
  return { input, label: make('label', {}, input, text) };
}

export function slider(text, attributes, input) {
  const range = make('input', { type: 'range', oninput: () => input(Number(range.value)), ...attributes });
  return { range, label: make('label', {}, text, range) };
}

export function choice(text, options, change) {
  const entries = options.map(([value, word]) => make('option', { value }, word));
  const select = make('select', { onchange: () => change(select.value) }, ...entries);
  return make('label', {}, text, select);
}

/** Bodies by what they are, each with a box that shows it and a button that tells of it. */
export function tree(bodies, show, choose) {
  const groups = Object.entries(GROUPS).map(([kind, title]) => {
    const own = bodies.filter((body) => body.extras.kind === kind);
    if (own.length === 0) return '';
    const refresh = () => {
      const shown = own.filter((body) => body.object.visible).length;
      all.input.checked = shown > 0;
      all.input.indeterminate = shown > 0 && shown < own.length;
    };
    const all = checkbox(title, true, (isOn) => {
      for (const body of own) {
        body.box.checked = isOn;
        show(body, isOn);
      }
      refresh();
    });
    const rows = own.map((body) => {
      body.box = make('input', {
        type: 'checkbox', 'aria-label': `show ${body.name}`,
        onchange: () => {
          show(body, body.box.checked);
          refresh();
        },
      });
      body.box.checked = true;
      body.button = button(body.name, () => choose(body), { 'aria-pressed': 'false' });
      body.swatch = make('span', { class: 'swatch', style: `background:#${body.material.color.getHexString()}` });
      return make('li', {}, body.box, body.swatch, body.button);
    });
    return make('fieldset', {}, make('legend', {}, all.label), make('ul', {}, ...rows));
  });
  return groups.filter((group) => group !== '');
}

const round = (value, digits) => Number(value.toFixed(digits)).toString();

/** What the design says of a body. */
export function facts({ name, extras }) {
  const sides = extras.size_mm?.map((side) => round(side, 2)).join(' × ');
  const rows = [
    ['What it is', extras.summary],
    ['Material', extras.material],
    ['Made by', extras.process],
    ['Quantity', extras.quantity],
    ['Size', sides && `${sides} mm`],
    ['Volume', extras.volume_mm3 && `${round(extras.volume_mm3 / 1000, 3)} cm³`],
    ['Mass of one, solid', extras.mass_g && `${round(extras.mass_g, 2)} g`],
    ['Refractive index', extras.refractive_index],
    ...(extras.parameters ?? []).map(({ path, value }) => [path, value]),
  ];
  const known = rows.filter(([, value]) => value !== undefined && value !== '');
  const list = known.flatMap(([term, value]) => [make('dt', {}, term), make('dd', {}, `${value}`)]);
  return [make('h3', {}, name), make('dl', {}, ...list)];
}
