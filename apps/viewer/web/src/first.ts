// The first minute: one object large, the others pale behind it, and one invitation, until it is touched.
import * as THREE from 'three';
import { canvas, hand, invite, stage, world } from './stage';
import { saved } from './net';
import { on, state } from './state';

/// The others are pale; -1: all alike.
export function lookAt(object: number): void {
  if (world.objects.focus === object) return;
  world.objects.focus = object;
  void world.objects.paint();
}

let invites = !saved;

/// Of several objects the one with most parts: it has most to touch.
export function firstMinute(): void {
  const rich = state.facts.reduce((best, f, i) => (f.parts.length > (state.facts[best]?.parts.length ?? 0) ? i : best), 0);
  world.frame(state.facts.length ? rich : -1);
  if (state.facts.length > 1) lookAt(rich);
  follow();
}

/// Over the highest point of the object that is seen there.
function follow(): void {
  const object = Math.max(world.objects.focus, 0);
  invite.hidden = !invites || state.mode !== 'touch' || state.playing || !state.facts[object];
  if (invite.hidden) return;
  const box = world.objects.box(object), middle = box.getCenter(new THREE.Vector3());
  const p = world.project(middle);
  let y = world.project(new THREE.Vector3(middle.x, box.max.y, middle.z)).y;
  while (y > p.y && world.cast(p.x, y, object) === null) y -= 0.02;
  invite.style.transform = `translate(${(0.5 * (p.x + 1) * world.size.x).toFixed(0)}px, ${Math.max(0.5 * (1 - y) * world.size.y - 16, 58).toFixed(0)}px) translate(-50%, -100%)`;
}

/// Nobody needs it who has touched, or has opened what was felt.
export const endInvitation = (): void => { invites = false; invite.hidden = true; };
document.addEventListener('pointerdown', () => setTimeout(() => { if (hand.holding) endInvitation(); }), true);
canvas.addEventListener('keydown', () => { if (hand.holding) endInvitation(); });
world.controls.addEventListener('change', follow);
new ResizeObserver(() => requestAnimationFrame(follow)).observe(stage);
on(['mode', 'playing'], follow);
