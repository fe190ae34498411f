// Moves an object: by handles on the stage, by numbers, and by the axis of its file that points upwards.
import * as THREE from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import { announce, digits, h } from '../dom';
import { vector } from '../geometry';
import type { ObjectFacts, Up } from '../messages';
import { link } from '../net';
import { trouble } from '../notices';
import { canvas, world } from '../stage';
import { on, state } from '../state';
import { choice } from './controls';

let moved = -1; ///< the id of the object that is being moved; -1: none
export const movedNow = (): number => moved;
const indexOf = (id: number): number => state.facts.findIndex((f) => f.id === id);

const proxy = new THREE.Object3D();
let handles: TransformControls | null = null;
/// Makes the handles when they are first wanted.
function made(): TransformControls {
  if (handles) return handles;
  const scene = world.extra.parent!,
    controls = new TransformControls(world.camera, canvas);
  controls.setSize(0.7);
  controls.addEventListener('change', () => world.redraw());
  controls.addEventListener('dragging-changed', ({ value }) => {
    world.controls.enabled = !value;
    if (!value) say(proxy.position);
  });
  controls.addEventListener('objectChange', () => {
    world.objects.preview(indexOf(moved), proxy.position);
  });
  scene.add(proxy, controls.getHelper());
  return (handles = controls);
}

function say(at: THREE.Vector3): void {
  const f = state.facts[indexOf(moved)];
  if (!f || at.distanceTo(vector(f.position)) < 1e-7) return;
  link.say({ say: 'move', object: indexOf(moved), p: at.toArray().map((x) => Number(x.toFixed(6))) });
  announce(`${f.name} moved.`);
}

/// Begins to move an object; -1: ends it.
export function move(id: number): void {
  moved = id;
  place();
}
/// Shows the handles at the object that is being moved.
function place(): void {
  const f = state.facts[indexOf(moved)],
    seen = f && !f.hidden && state.mode === 'look' && world.renderer !== null;
  if (!seen) {
    handles?.detach();
    world.redraw();
    return;
  }
  const controls = made();
  if (!controls.dragging) proxy.position.copy(vector(f.position));
  controls.attach(proxy);
  world.redraw();
}
on(['scene', 'mode'], place);

/// The numbers of an object that is being moved.
export function moveFields(f: ObjectFacts): HTMLElement {
  const field = (axis: number) =>
    h('input', {
      type: 'number',
      id: `move-${'xyz'[axis]}`,
      step: '5',
      value: digits(1000 * f.position[axis], 5),
      'aria-label': `${['To the right', 'Upwards', 'To the front'][axis]}, millimetres`,
      onchange: (e: Event) => {
        const { value } = e.target as HTMLInputElement,
          to = vector(f.position).setComponent(axis, value ? Number(value) / 1000 : f.position[axis]);
        if (value && to.toArray().every((x) => Math.abs(x) <= 5)) {
          say(to);
          return;
        }
        (e.target as HTMLInputElement).value = digits(1000 * f.position[axis], 5);
        trouble(`${f.name} stays where it is: a position is a number of millimetres, 5000 at most.`);
      },
    });
  const up = choice<Up>(
    'Upwards',
    [
      ['x', 'x of its file'],
      ['y', 'y of its file'],
      ['z', 'z of its file'],
    ],
    f.up,
    (axis) => {
      link.say({ say: 'turn', object: indexOf(f.id), up: axis });
      announce(`${f.name}: ${axis} points upwards.`);
    },
    'up-axis',
  );
  return h(
    'div',
    { class: 'move', role: 'group', 'aria-label': `Move ${f.name}` },
    h(
      'div',
      { class: 'field range' },
      h('span', {}, 'Middle'),
      h('div', { class: 'row' }, field(0), field(1), field(2), h('span', {}, 'mm')),
    ),
    up,
  );
}
