// The first minute: one object large, the others pale behind it, and one invitation, until it is touched.
import type { ObjectFacts } from './messages';
import { canvas, hand, invite, purpose, stage, world } from './stage';
import { saved } from './net';
import { changed, on, state } from './state';

/// Draws all objects but one pale; -1: none.
export function lookAt(object: number): void {
  if (world.objects.focus === object) return;
  world.objects.focus = object;
  void world.objects.paint();
  follow();
  changed('focus');
}

let invites = !saved;

/// Shows the object with most parts large, since it has most to touch; one without triangles, which no pointer finds, only alone.
export function firstMinute(): void {
  const parts = (f?: ObjectFacts) => (f?.hasTriangles ? f.parts.length : 0),
    rich = state.facts.reduce((best, f, i) => (parts(f) > parts(state.facts[best]) ? i : best), 0);
  if (state.facts.length > 1) {
    world.frameClosely(rich);
    lookAt(rich);
  } else world.frame();
  follow();
}

/// Moves the invitation over the point of the object that is highest on the screen.
function follow(): void {
  const object = Math.max(world.objects.focus, 0);
  invite.hidden =
    !invites || !!state.facts[object]?.hidden || state.mode !== 'touch' || state.playing || !state.facts[object]?.hasTriangles;
  if (invite.hidden) return;
  const top = world.highest(object),
    half = 0.5 * invite.offsetWidth + 8;
  const at = 0.5 * (top.x + 1) * world.size.x,
    x = Math.min(Math.max(at, half), world.size.x - half);
  invite.style.setProperty('--tip', `${Math.min(Math.max(at - x, 24 - half), half - 24).toFixed(0)}px`);
  invite.style.transform = `translate(${x.toFixed(0)}px, ${Math.max(0.5 * (1 - top.y) * world.size.y - 16, 58).toFixed(0)}px) translate(-50%, -100%)`;
}

/// Ends the invitation once the user has touched the object or opened a recording.
export const endInvitation = (): void => {
  invites = false;
  invite.hidden = purpose.hidden = true;
};
document.addEventListener(
  'pointerdown',
  () =>
    setTimeout(() => {
      if (hand.holding) endInvitation();
    }),
  true,
);
canvas.addEventListener('keydown', () => {
  if (hand.holding) endInvitation();
});
world.controls.addEventListener('change', follow);
new ResizeObserver(() => requestAnimationFrame(follow)).observe(stage);
on(['mode', 'playing'], () => {
  purpose.hidden = !invites || state.mode !== 'touch' || state.playing;
  follow();
});
