// Words for people who do not see the tool: its position, the direction of its force, whether a part was touched before. Directions
// are those of the eye: 6 o'clock is near, 3 o'clock on the right.
import * as THREE from 'three';
import { treeOf, vector } from './geometry';
import type { Frame } from './messages';
import { world } from './stage';
import { state } from './state';

/// hour: 1 to 12 about the object's upright axis, 0 on it. third: of its height, 0 is the lowest. out: m from that axis. side, height:
/// from -1 on the left to 1 on the right of its box, and from 0 at its foot to 1 at its top.
export interface Where {
  hour: number;
  third: number;
  out: number;
  side: number;
  height: number;
}

/// The eye's directions along the ground, to the right and away from the eye.
function ground(): { right: THREE.Vector3; away: THREE.Vector3 } {
  const away = world.direction().negate().setY(0);
  if (away.length() < 1e-6) away.set(0, 0, -1).applyQuaternion(world.camera.quaternion).setY(0); // the eye looks straight down
  away.normalize();
  return { away, right: new THREE.Vector3().crossVectors(away, new THREE.Vector3(0, 1, 0)) };
}

const NEAR_AXIS = 0.12; // of the box's half width: nearer than this to the axis there is no direction

/// object: the one whose middle and height count; null where there is none.
export function whereIs(tool: number[], object: number): Where | null {
  const facts = state.facts[object];
  if (!facts) return null;
  const from = vector(tool).sub(vector(facts.position)),
    { right, away } = ground(),
    half = vector(facts.half);
  const x = from.dot(right),
    z = from.dot(away),
    out = Math.hypot(x, z),
    wide = Math.abs(right.x) * half.x + Math.abs(right.z) * half.z;
  const hour = out < NEAR_AXIS * Math.max(half.x, half.z) ? 0 : ((Math.round((6 * Math.atan2(x, z)) / Math.PI) + 11) % 12) + 1;
  const height = Math.min(Math.max(0.5 + (0.5 * from.y) / Math.max(half.y, 1e-9), 0), 1);
  return {
    hour,
    third: Math.min(Math.floor(3 * height), 2),
    out,
    side: Math.min(Math.max(x / Math.max(wide, 1e-9), -1), 1),
    height,
  };
}

const THIRDS = ['lower third', 'middle third', 'upper third'];
export const millimetres = (m: number): string => {
  const n = Math.round(1000 * Math.max(m, 0));
  return `${n} millimetre${n === 1 ? '' : 's'}`;
};
/// "4 o'clock, upper third", in full also how far from the axis.
export function whereWords(w: Where, full = false): string {
  return `${w.hour ? `${w.hour} o'clock` : 'in the middle'}, ${THIRDS[w.third]}${full && w.hour ? `, ${millimetres(w.out)} out` : ''}`;
}

/// "pushes up and towards you".
export function forceWords(force: number[]): string {
  const f = vector(force),
    { right, away } = ground();
  if (f.length() < 0.02) return '';
  f.normalize();
  const parts = [
    [f.y, 'up', 'down'],
    [f.dot(right), 'right', 'left'],
    [f.dot(away), 'away from you', 'towards you'],
  ] as [number, string, string][];
  const said = parts
    .filter(([x]) => Math.abs(x) > 0.38)
    .sort((a, b) => Math.abs(b[0]) - Math.abs(a[0]))
    .map(([x, plus, minus]) => (x > 0 ? plus : minus));
  return `pushes ${said.join(' and ')}`;
}

/// The side from which the eye sees the middle of the view: "from the front, right, 17 degrees above".
export function viewWords(): string {
  const d = world.direction(),
    turn = Math.round((Math.atan2(d.x, d.z) * 180) / Math.PI),
    up = Math.round((Math.asin(d.y) * 180) / Math.PI),
    to = Math.abs(turn);
  const side = `${to < 67.5 ? 'from the front' : to > 112.5 ? 'from behind' : 'from'}${to > 22.5 && to < 157.5 ? `${to < 67.5 || to > 112.5 ? ', ' : ' the '}${turn > 0 ? 'right' : 'left'}` : ''}`;
  return `${side}, ${up === 0 ? 'level' : `${Math.abs(up)} degrees ${up > 0 ? 'above' : 'below'}`}`;
}

/// m from the tool's surface to an object's; null where that is not drawn.
export function distanceTo(tool: number[], object: number): number | null {
  const mesh = world.objects.meshOf(object),
    found = mesh && treeOf(mesh).closestPointToPoint(vector(tool));
  return found ? Math.max(found.distance - (state.settings.tool === 'ball' ? state.settings.toolRadius : 0), 0) : null;
}

/// The parts that were touched, for "touched before". A part that is touched on and on stays what it was when the touch began.
export class Memory {
  private met = new Set<string>();
  private now = '';
  private knew = false;

  /// The frame's part is touched; true where it was touched and left before.
  hear(frame: Frame): boolean {
    const key = frame.contacts > 0 ? `${frame.object} ${frame.part}` : '';
    if (key === this.now) return this.knew;
    this.now = key;
    this.knew = this.met.has(key);
    if (key) this.met.add(key);
    return this.knew;
  }
  forget(): void {
    this.met.clear();
    this.now = '';
    this.knew = false;
  }
}
export const memory = new Memory();
