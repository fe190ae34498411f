// Shows a frame of touch, from the servo or from a recording: it sounds at once and is drawn with the next picture.
import * as THREE from 'three';
import { Charts } from './charts';
import { setDent } from './skin';
import { announce, h } from './dom';
import { vector } from './geometry';
import { meter } from './meter';
import type { Frame } from './messages';
import { rumble, sound, voice } from './panels/senses';
import { depthWords, showPress } from './press';
import { forceRead, forceTag, hand, world } from './stage';
import { on, state } from './state';
import { heardStop, onStop } from './stop';
import { onTheme } from './theme';
import { distanceTo, forceWords, memory, millimetres, whereIs, whereWords } from './where';

export const charts = new Charts();
onTheme(() => charts.theme());
onStop(() => sound.quiet());

const REASONS: [number, string][] = [
  [1, 'not a number'],
  [2, 'no fresh position'],
  [4, 'easing in'],
  [8, 'at the force limit'],
  [16, 'rising gently'],
  [32, 'too fast'],
  [64, 'damped to stay stable'],
  [128, 'resting the motors'],
  [256, 'at the last limit'],
  [512, 'off'],
];

let toDraw: Frame | null = null;
/// Listeners that want every frame.
const witnesses: ((frame: Frame) => void)[] = [];
export function onFelt(witness: (frame: Frame) => void): void {
  witnesses.push(witness);
}

/// Shows a frame. replayed: it is from a recording; again: force, torque and depth of its ticks as computed again, if they were.
export function show(frame: Frame, replayed = false, again: Float32Array | null = null): void {
  charts.add(frame, again);
  if (state.mode === 'look' || state.mode === 'dress') return;
  toDraw = frame;
  world.wake();
  const force = Math.hypot(...frame.force);
  if (frame.object >= 0 && state.facts[frame.object]) sound.size = 2 * Math.max(...state.facts[frame.object].half);
  const about = aboutObject(frame),
    where = whereIs(frame.tool, about),
    knew = memory.hear(frame);
  sound.play(frame, where?.side ?? world.project(toolPoint.fromArray(frame.tool)).x);
  if (where && (hand.holding || replayed)) sound.place(frame.tool, where.height);
  rumble.play(force, state.settings.forceLimit);
  for (const witness of witnesses) witness(frame);
  const touches = frame.contacts > 0 && !(state.mode === 'recognise' && !state.playing);
  voice.touch(touches ? touchedName(frame) : '', knew, where && touches ? whereWords(where) : '');
  if (frame.faults & 16 && !replayed) heardStop();
}
const toolPoint = new THREE.Vector3();
/// The object that words about a position are about: the touched one, in a round the hidden one, else the one that is looked at.
const aboutObject = (frame: Frame): number =>
  frame.contacts > 0 && frame.object >= 0
    ? frame.object
    : hand.only >= 0
      ? hand.only
      : state.touched >= 0
        ? state.touched
        : Math.max(world.objects.focus, 0);
on(['playing', 'scene'], () => memory.forget());
/// The name of the touched part. During a round of recognition only its number, since the name would tell the object.
const touchedName = (frame: Frame): string =>
  state.playing
    ? frame.part >= 0
      ? `part ${frame.part + 1}`
      : 'surface'
    : ((frame.object >= 0 ? state.facts[frame.object]?.parts[frame.part]?.name : undefined) ?? 'surface');

export function hideTool(): void {
  toDraw = null;
  showPress(null);
  setDent(null);
  world.tool.show(null);
  forceRead.textContent = '';
  forceTag.hidden = true;
}

/// Shows the force beside the head of its arrow.
export function showTag(force: number, from = toolPoint): void {
  const tip = world.tool.tipOfArrow();
  if (forceTag.hidden !== !tip) forceTag.hidden = !tip;
  if (!tip) return;
  // The tag stands beyond the tip, in the direction of the arrow on the screen.
  const p = world.pixel(tip),
    { x: wide, y: high } = world.size,
    away = p.clone().sub(world.pixel(from)).setLength(30);
  const x = Math.min(Math.max(p.x + away.x, 36), wide - 36),
    y = Math.min(Math.max(p.y + 0.7 * away.y, 14), high - 14);
  forceTag.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px) translate(-50%, -50%)`;
  const text = `${force.toFixed(1)} N`;
  if (forceTag.textContent !== text) forceTag.textContent = text;
}

export function draw(frame: Frame): void {
  const touches = frame.contacts > 0 && !world.objects.hidden,
    force = Math.hypot(...frame.force);
  if (touches) setDent(vector(frame.point), vector(frame.normal).negate(), frame.depth);
  else setDent(null);
  world.tool.show(frame, (from, to) => world.inSight(from, to));
  showTag(force);
  // The last limit acts with the first one and says the same.
  const acted = frame.acted & 8 ? frame.acted & ~256 : frame.acted;
  const why = REASONS.filter(([bit]) => (acted & bit) !== 0).map(([, text]) => text);
  const words = !frame.connected
    ? 'device gone'
    : frame.faults & 16
      ? 'stopped'
      : frame.faults
        ? 'no force: the filter found a fault (the computer was busy?). Lift and touch again'
        : frame.contacts > 0 && !frame.engaged && force === 0
          ? 'no force yet: lift once, then it comes in gently'
          : frame.contacts > 0
            ? `${force.toFixed(2)} N · ${depthWords(frame)} · ${touchedName(frame)}`
            : 'free';
  const text = words + (why.length && frame.contacts > 0 ? ` · ${why.join(', ')}` : '');
  if (forceRead.textContent !== text) forceRead.textContent = text;
  showPress(frame);
}

export const pageCost = h('p', { class: 'note', id: 'page-cost' });
let costDue = 0;
world.onFrame = (now) => {
  if (toDraw) meter.spend('message', () => draw(toDraw as Frame));
  toDraw = null;
  meter.spend('charts', () => charts.frame(now));
  if (now >= costDue) {
    costDue = now + 1000;
    pageCost.textContent = meter.words();
  }
  return charts.wanting;
};
charts.onChange = () => world.wake();
voice.onSay = (text) => {
  if (text && state.mode !== 'look') announce(text);
};

/// Distance to an object for a tool that touches nothing.
function awayWords(frame: Frame | null, object: number): string {
  const away = frame && distanceTo(frame.tool, object);
  return away === null || away === undefined ? '' : `The surface is ${millimetres(away)} away.`;
}

let sought = '';
hand.onSeek = (object, distance, direction) => {
  if (object === null) {
    sought = '';
    return;
  }
  sound.guide(distance);
  const name = state.playing ? 'the object' : (state.facts[object]?.name ?? 'the object'),
    wanted = hand.wanted,
    away = wanted && distanceTo(wanted.toArray(), object);
  const text = `Nothing here: ${name} is ${direction}${direction === 'close by' ? '' : distance > 0.5 ? ', far' : ', near'}${away === null ? '' : `, ${millimetres(away)} away`}.`;
  if (text !== sought) announce(text);
  sought = text;
};

// Answers the question what is touched and where the tool is, also where nothing has changed.
hand.onAsk = () => {
  const f = state.frame,
    touches = f !== null && f.contacts > 0;
  if (hand.waits) {
    voice.answer('The tool is on its way down');
    return;
  }
  if (!f || (!touches && !hand.holding)) {
    voice.answer('Touching nothing');
    return;
  }
  const about = aboutObject(f),
    where = whereIs(f.tool, about),
    at = where ? whereWords(where, true) : '',
    push = touches ? forceWords(f.force) : '';
  const first = touches
    ? `${touchedName(f)}, ${memory.hear(f) ? 'touched before' : 'new'}, ${Math.hypot(...f.force).toFixed(1)} newtons${push ? `, ${push}` : ''}`
    : 'Touching nothing';
  voice.answer([first, at, touches ? '' : awayWords(f, about).replace(/\.$/, '')].filter((t) => t).join('. '));
};
