// The stage: the canvas with the scene, and what lies over it.
import { css, type Scale } from './colours';
import { fill, h } from './dom';
import { Hand } from './hand';
import { trouble } from './notices';
import { onTheme } from './theme';
import { World } from './world';

export const canvas = h('canvas', {
  id: 'stage',
  tabIndex: 0,
  role: 'application',
  'aria-label':
    'The scene. To look: arrow keys turn it, plus and minus bring it nearer and farther, Home shows all, Enter tells what is in the middle. To touch: arrow keys move the tool, Enter touches and lifts, Page Down presses harder, Q and E walk round, N says what is touched, Space stops. To dress: arrow keys move a cross, Enter takes cloth and lets go, P pins, C begins a cut and ends it.',
});
export const hint = h('p', { class: 'hint', id: 'hint' });
const scaleBox = h('div', {});
export const legend = h('div', { class: 'legend', hidden: true }, scaleBox);
export const forceRead = h('output', { class: 'force', id: 'force', 'aria-live': 'off' });
export const factsLine = h('p', { class: 'facts-line', id: 'model-facts' }); // stays in sight while the panel scrolls
export const forceTag = h('div', { class: 'force-tag', hidden: true, 'aria-hidden': 'true' }); // hidden from screen readers: the words in the corner say the same
export const invite = h('div', { class: 'invite', id: 'invite', hidden: true, 'aria-hidden': 'true' }, 'Press and drag on me');
/// The purpose of the page, shown until the first touch. Its words stand in index.html, so that they are read while the rest loads;
/// a saved page has none.
export const purpose = document.getElementById('purpose') ?? h('p', { id: 'purpose' });
/// The titles of two views side by side.
export const sides = h('div', { class: 'sides', id: 'sides', hidden: true }, h('span', {}), h('span', {}));
export const stage = h(
  'div',
  { class: 'stage' },
  canvas,
  sides,
  forceTag,
  invite,
  hint,
  legend,
  h('div', { class: 'corner' }, purpose, forceRead, factsLine),
);
export const world = new World(canvas);
if (!world.renderer)
  stage.append(
    h(
      'div',
      { class: 'no-picture', id: 'no-picture', role: 'note' },
      h('p', {}, 'This browser shows no 3D picture: WebGL is off or missing.'),
      h(
        'p',
        {},
        'Switch on hardware acceleration or WebGL in its settings, or open the address in another browser. Until then touch works by keys: Enter touches, arrows move, N says what is touched, with sound and numbers.',
      ),
    ),
  );
export const hand = new Hand(world, canvas);
onTheme(() => world.theme());

export function showHint(text: string): void {
  hint.textContent = text;
  hint.hidden = false;
}

/// Layer 3 finds no contact at such points, and how far inside they lie. The program's counts and the command info mean the same.
export const MISSED = '0.5 % of its size or more inside, and layer 3 finds no contact';
export const HELD = 'Touch by exact triangles holds it.';
function errorNote(): string {
  const { missed, held, second } = world.objects.missedNow(),
    count = (n: number) => (n === 0 ? 'none here' : `${n.toLocaleString('en')} triangle${n === 1 ? '' : 's'}`);
  return `Blue: missed (${sides.hidden ? count(missed) : `layer 3: ${count(missed)}; layer 2: ${count(second)}`}): ${sides.hidden ? MISSED : MISSED.replace('layer 3', 'the layer')}.${missed && held ? ` ${HELD}` : ''} Grey: too thin to say.`;
}
const NOTES: Record<string, string> = {
  locales: 'A colour for each feature, paler in every second locale. Grey: no feature is reached.',
  regions: 'Grey: not known, as of all models but paper models (bake as the paper).',
  difference:
    '1 % of its size below the surface. Blue: only one finds contact. Grey: neither does. Baked one way alone: its parts.',
};
/// Tooltips of the colours: where the paper defines each quantity.
const TIPS: Record<string, string> = {
  protrusion: 'Eq. 4 of the paper',
  curvature: 'Eq. 6 of the paper; size: its R_max, the largest distance between two vertices',
  locales: 'Section 3.1 of the paper',
  strength: 'Section 3.1 of the paper',
  regions: 'Section 5 of the paper: convex, Q1 and Q2',
};
world.objects.onTrouble = trouble;
world.objects.onWait = (kind, done, of) => {
  const names: Record<string, string> = {
    error: 'depth error',
    'error-2': 'depth error of layer 2',
    protrusion: 'protrusion',
    curvature: 'curvature',
    locales: 'locales',
    strength: 'Boundary Strength',
    regions: 'regions',
    'made-up': 'made-up surface',
    difference: 'difference',
  };
  legend.hidden = false;
  fill(
    scaleBox,
    h('span', { id: 'waiting' }, `Computing the ${names[kind] ?? kind}: ${done} of ${of} objects …`),
    h('progress', { max: of, value: done, 'aria-label': 'Computing' }),
  );
};
const scaleListeners: ((scale: Scale | null) => void)[] = [];
export function onScale(listener: (scale: Scale | null) => void): void {
  scaleListeners.push(listener);
}
world.objects.onScale = (scale) => {
  for (const listener of scaleListeners) listener(scale);
};
onScale((scale) => {
  const q2 = world.objects.hiddenShare.length
    ? h(
        'span',
        { class: 'note', id: 'q2', title: 'Q2 of section 5 of the paper' },
        `Magenta: hidden from its part's projection, of the surface: ${world.objects.hiddenShare.join(', ')}`,
      )
    : '';
  legend.hidden = !scale && !q2;
  if (!scale) {
    fill(scaleBox, q2);
    return;
  }
  const stops = Array.from({ length: 9 }, (_, i) => css(scale.colour(i / 8))).join(',');
  scaleBox.replaceChildren(
    h(
      'span',
      { title: TIPS[world.objects.colourBy] ?? 'Size: the largest distance between two vertices, the paper’s R_max' },
      sides.hidden ? scale.title : scale.title.replace(' of layer 3', ''),
    ),
    h('div', { class: 'bar', style: `background:linear-gradient(90deg,${stops})` }),
    h('div', { class: 'ticks' }, ...scale.ticks.map(([, t]) => h('span', {}, t))),
    h('span', { class: 'note' }, world.objects.colourBy === 'error' ? errorNote() : (NOTES[world.objects.colourBy] ?? '')),
    q2,
  );
});
