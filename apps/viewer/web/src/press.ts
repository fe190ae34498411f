// The press of the hand and the depth at which the surface holds the tool, in words and as a small drawing: a cut through the surface.
import { h, svg } from './dom';
import type { Frame } from './messages';
import { hand } from './stage';
import { on, state } from './state';

const WIDE = 300,
  HIGH = 96,
  GROUND = 34,
  SCALE = 2.6; // px; px a millimetre

const picture = svg('svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, class: 'press-picture', 'aria-hidden': 'true' });
const words = h('p', { class: 'note', id: 'press-words' });
export const pressBox = h('div', {}, picture as unknown as HTMLElement, words);

const mm = (metres: number): string => (1000 * metres).toFixed(1);

/// How far the hand wants the tool below the surface, and how far it is, m. A recording does not know the wish.
export function depths(frame: Frame): { hand: number; tool: number } {
  const wanted = hand.wanted,
    apart = wanted ? frame.hand.reduce((sum, x, k) => sum + (x - wanted.getComponent(k)) * frame.normal[k], 0) : 0;
  return { hand: frame.depth + Math.max(apart, 0), tool: frame.depth };
}

/// The depth of a touch in words.
export function depthWords(frame: Frame): string {
  const d = depths(frame);
  return d.hand - d.tool < 1e-4 ? `${mm(d.tool)} mm deep` : `hand ${mm(d.hand)} mm in, surface holds it ${mm(d.tool)} mm deep`;
}

/// A cut through the surface: the tool as a ball, the hand as a dot, a spring between them.
function picturePress(hand: number, tool: number, touches: boolean): void {
  const x = 66,
    r = Math.min(1000 * state.settings.toolRadius * SCALE, 26),
    dent = touches ? 1000 * tool * SCALE : 0;
  const handAt = GROUND + 1000 * hand * SCALE,
    ball = GROUND + dent - r,
    half = 2.2 * r;
  const dimple = touches
    ? `C ${x - half} ${GROUND} ${x - 0.9 * r} ${GROUND + dent} ${x} ${GROUND + dent} S ${x + half} ${GROUND} ${x + 2 * half} ${GROUND}`
    : '';
  // One label stands above the line of the surface, the other below it: neither is crossed by the line.
  const labels = [
    [GROUND - 6, touches ? `surface holds it: ${mm(tool)} mm` : 'surface'],
    [Math.max(handAt + 4, GROUND + 15), `hand: ${mm(hand)} mm`],
  ] as [number, string][];
  picture.replaceChildren(
    svg('path', { d: `M 0 ${GROUND} H ${Math.max(x - 2 * half, 0)} ${dimple} H ${WIDE} V ${HIGH} H 0 Z`, class: 'press-solid' }),
    svg('circle', { cx: x, cy: ball, r, class: 'press-tool' }),
    svg('line', { x1: x, y1: ball + r, x2: x, y2: handAt, class: 'press-spring' }),
    svg('circle', { cx: x, cy: handAt, r: 3.5, class: 'press-hand' }),
    ...labels.map(([y, text], i) =>
      svg('text', { x: x + 38, y: Math.min(y, HIGH - 4), class: i === 0 && touches ? 'press-depth' : '' }, text),
    ),
  );
}

let shown = '';
/// Shows a touch; null: only where the hand would press.
export function showPress(frame: Frame | null): void {
  const touches = frame !== null && frame.contacts > 0,
    d = touches ? depths(frame) : { hand: hand.press, tool: 0 };
  const text = touches
    ? d.hand - d.tool < 1e-4
      ? `The tool is ${mm(d.tool)} mm deep.`
      : `The hand is ${mm(d.hand)} mm in; the surface holds the tool ${mm(d.tool)} mm deep.`
    : hand.press > 0
      ? `A press goes ${mm(hand.press)} mm below the surface; the surface holds the tool before that.`
      : 'The hand stays above the surface.';
  const key = `${text}${state.settings.toolRadius}`;
  if (key === shown) return;
  shown = key;
  words.textContent = text;
  picturePress(d.hand, d.tool, touches);
}
hand.onPress = () => {
  if (!hand.holding) showPress(null);
};
on(['status'], () => {
  if (!hand.holding) showPress(null);
});
