// Tools of inspection: standard views, a slice with the signed distance on it, the distance between two clicks.
import * as THREE from 'three';
import { divergingColour } from '../colours';
import { digits, fill, h } from '../dom';
import { vector } from '../geometry';
import { fetchBytes } from '../net';
import { trouble } from '../notices';
import { world } from '../stage';
import { on, state } from '../state';
import { card, check, choice, folded } from './controls';

export const VIEWS: [string, string, [number, number, number]][] = [
  ['front', 'Front', [0, 0, 1]],
  ['back', 'Back', [0, 0, -1]],
  ['left', 'Left', [-1, 0, 0]],
  ['right', 'Right', [1, 0, 0]],
  ['top', 'Top', [0, 1, 0.001]],
  ['below', 'Below', [0, -1, 0.001]],
  ['corner', 'Corner', [0.6, 0.5, 0.8]],
];
/// Shows the selected object, else all, from a standard direction.
export function lookFrom(view: number): void {
  world.frame(state.selected?.object ?? world.objects.focus, vector(VIEWS[view][2]).normalize());
}
const views = h(
  'div',
  { class: 'row wrap views', role: 'group', 'aria-label': 'Standard views' },
  ...VIEWS.map(([id, name], i) =>
    h('button', { class: 'small', id: `view-${id}`, title: `Key ${i + 1}`, onclick: () => lookFrom(i) }, name),
  ),
);

// ---- The distance between two clicks

let measures = false;
export const measuring = (): boolean => measures;
let from: THREE.Vector3 | null = null;
const span = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd4145a, depthTest: false }));
span.renderOrder = 12;
span.visible = false;
world.extra.parent!.add(span);
const measured = h('p', { id: 'measured', role: 'status' });
const measureSwitch = check(
  'Distance between two clicks',
  false,
  (yes) => {
    measures = yes;
    from = null;
    span.visible = false;
    fill(measured, yes ? 'Click the first point.' : '');
    world.redraw();
  },
  'measure',
);
on(['pick'], () => {
  const p = state.pick?.point;
  if (!measures || !p) return;
  if (!from) {
    from = p.clone();
    span.visible = false;
    fill(measured, 'Click the second point.');
    world.redraw();
    return;
  }
  span.geometry.setFromPoints([from, p]);
  span.visible = true;
  const d = p.clone().sub(from),
    f = state.facts[state.pick!.object];
  fill(
    measured,
    `${digits(1000 * d.length(), 4)} mm (x ${digits(1000 * d.x)}, y ${digits(1000 * d.y)}, z ${digits(1000 * d.z)}), ${digits(d.length() / f.metresPerUnit, 4)} in the file's units. Click for another.`,
  );
  from = null;
  world.redraw();
});

// ---- A slice

let axis = -1,
  share = 0.5,
  asked = 0;
const SHOWN = 0.02; // m, the distance at which the colours end
const sheet = new THREE.Mesh(
  new THREE.BufferGeometry(),
  new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, transparent: true, opacity: 0.92 }),
);
sheet.visible = false;
sheet.raycast = () => {};
world.extra.parent!.add(sheet);
const words = h('p', { class: 'note', id: 'slice-words' });
const slider = h('input', {
  type: 'range',
  id: 's-slice',
  min: '0',
  max: '100',
  step: '1',
  value: '50',
  'aria-label': 'Position of the slice',
  oninput: () => {
    share = Number(slider.value) / 100;
    due();
  },
});

/// Signed distance as colours, blue inside and red outside, with a line every 5 mm and a black one at the surface.
function picture(values: Float32Array, side: number): THREE.CanvasTexture {
  const canvas = document.createElement('canvas'),
    scale = 4;
  canvas.width = canvas.height = scale * side;
  const c = canvas.getContext('2d')!,
    image = c.createImageData(canvas.width, canvas.height);
  const at = (x: number, y: number) => {
    const i = Math.min(Math.floor(x), side - 2),
      j = Math.min(Math.floor(y), side - 2),
      u = x - i,
      v = y - j,
      k = j * side + i;
    return (1 - v) * ((1 - u) * values[k] + u * values[k + 1]) + v * ((1 - u) * values[k + side] + u * values[k + side + 1]);
  };
  for (let y = 0; y < canvas.height; ++y)
    for (let x = 0; x < canvas.width; ++x) {
      const gx = (x / (canvas.width - 1)) * (side - 1),
        gy = (y / (canvas.height - 1)) * (side - 1),
        d = at(gx, gy);
      const slope = Math.hypot(at(Math.min(gx + 0.25, side - 1), gy) - d, at(gx, Math.min(gy + 0.25, side - 1)) - d) + 1e-7,
        step = 0.005;
      const line = Math.abs(d) < 1.6 * slope ? 0 : Math.abs(d / step - Math.round(d / step)) * step < 0.7 * slope ? 0.55 : 1;
      const colour = divergingColour(Math.max(-1, Math.min(1, d / SHOWN)));
      image.data.set([...colour.map((v) => 255 * v * line), 255], 4 * ((canvas.height - 1 - y) * canvas.width + x));
    }
  c.putImageData(image, 0, 0);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

let timer = 0;
function due(): void {
  clearTimeout(timer);
  timer = window.setTimeout(() => void draw(), 80);
}

async function draw(): Promise<void> {
  const object = state.selected?.object ?? Math.max(world.objects.focus, 0),
    f = state.facts[object],
    request = ++asked;
  if (axis < 0 || !f || state.mode !== 'look') {
    sheet.visible = false;
    world.objects.cut(null);
    fill(words);
    return;
  }
  const through = f.position.map((x, k) => (k === axis ? x + (2 * share - 1) * f.half[k] : x));
  let data: ArrayBuffer;
  try {
    data = await fetchBytes(`/api/object/${object}/slice/${axis}?at=${through.map((x) => x.toFixed(6)).join('_')}`);
  } catch (e) {
    trouble(e);
    return;
  }
  if (request !== asked) return;
  const side = new Uint32Array(data, 4, 1)[0],
    head = new Float32Array(data, 8, 9),
    values = new Float32Array(data, 44);
  const corner = vector(head),
    along = vector(head, 3),
    up = vector(head, 6);
  const material = sheet.material as THREE.MeshBasicMaterial;
  material.map?.dispose();
  material.map = picture(values, side);
  material.needsUpdate = true;
  sheet.geometry.dispose();
  sheet.geometry = new THREE.BufferGeometry().setFromPoints([
    corner,
    corner.clone().add(along),
    corner.clone().add(along).add(up),
    corner.clone().add(up),
  ]);
  sheet.geometry.setAttribute('uv', new THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
  sheet.geometry.setIndex([0, 1, 2, 0, 2, 3]);
  sheet.visible = true;
  const normal = new THREE.Vector3().setComponent(axis, -1);
  world.objects.cut(new THREE.Plane(normal, corner.getComponent(axis)), object);
  const least = values.reduce((a, b) => Math.min(a, b), Infinity);
  fill(
    words,
    `${f.name}: the deepest point of the slice is ${digits(Math.max(-1000 * least, 0))} mm inside. Lines every 5 mm; black: the surface. Blue inside, red outside, full at ${1000 * SHOWN} mm.`,
  );
  world.redraw();
}
on(['selected', 'mode', 'scene'], due);

export const measureCards = [
  folded(
    'Slice with distances',
    'slice',
    choice(
      'Across',
      [
        ['off', 'Not shown'],
        ['0', 'x'],
        ['1', 'y (upward)'],
        ['2', 'z'],
      ],
      'off',
      (v) => {
        axis = v === 'off' ? -1 : Number(v);
        void draw();
      },
      'slice-axis',
    ),
    h('div', { class: 'field' }, h('span', {}, 'Position'), slider),
    words,
  ),
  card(
    'Measure',
    views,
    h(
      'div',
      { class: 'checks' },
      check('Axes', false, (yes) => world.showAxes(yes), 'axes'),
    ),
    measureSwitch,
    measured,
  ),
];
