// The choices of what is drawn.
import { announce, digits, h } from '../dom';
import { link, saved } from '../net';
import { trouble, wait } from '../notices';
import type { Range } from '../colours';
import { canvas, onScale, sides, world } from '../stage';
import { on, state } from '../state';
import { card, check, choice } from './controls';
import { measureCards } from './measure';
import { meetingsCard } from './meetings';
import { partBox } from './parts';

// The values at which the colours of a field end.
const rangeInput = (id: string, label: string) =>
  h('input', {
    type: 'number',
    id,
    step: 'any',
    'aria-label': label,
    onchange: () => setRange([Number(low.value), Number(high.value)]),
  });
const low = rangeInput('range-low', 'Colours from'),
  high = rangeInput('range-high', 'Colours to');
const rangeRow = h(
  'div',
  { class: 'field range', id: 'range', hidden: true },
  h('span', {}, 'Colours'),
  h(
    'div',
    { class: 'row' },
    low,
    h('span', {}, 'to'),
    high,
    h('button', { id: 'range-auto', class: 'small', title: 'As the values are', onclick: () => setRange(null) }, 'Auto'),
  ),
);
function setRange(range: Range): void {
  if (range && !(range.every(Number.isFinite) && range[0] < range[1])) {
    announce('The first number must be less than the second.', true);
    return;
  }
  world.objects.range = range;
  void world.objects.paint();
}
onScale((scale) => {
  rangeRow.hidden = !scale || scale.isOfKinds === true || world.objects.colourBy === 'made-up';
  if (!scale) return;
  low.value = digits(scale.range[0]);
  high.value = digits(scale.range[1]);
  low.disabled = world.objects.colourBy === 'curvature'; // the same on both sides of 0
});

const colourChoice = choice(
  'Colour by',
  [
    ['parts', 'Parts'],
    ['error', 'Depth error'],
    ['protrusion', 'Protrusion'],
    ['curvature', 'Curvature'],
    ['locales', 'Locales'],
    ['strength', 'Boundary Strength'],
    ['regions', 'Convex, concave, hidden'],
    ['made-up', 'Made up'],
    ['difference', 'Two projections'],
  ],
  'parts',
  (v) => {
    world.objects.colourBy = v;
    world.objects.range = null;
    void world.objects.paint();
  },
  'colour',
);

/// Bakes the selected object, else the one that is looked at, with the other projection too, where it has no twin yet; the two stand side
/// by side once it is there.
function bakeTwin(): void {
  const meant = state.selected?.object ?? world.objects.focus,
    object = Math.max(meant, 0),
    f = state.facts[object];
  if (meant < 0 ? world.objects.pair() : f?.twin !== null) return;
  if (!f.hasTriangles) {
    trouble('This model has no triangles to bake with other maps: open its mesh.');
    return;
  }
  const text = `Baking ${f.name} with ${f.central ? 'the paper’s' : 'central'} maps, too: both stand side by side then.`;
  wait(text);
  announce(text);
  link.say({ say: 'rebake', object });
}

// Two views side by side.
type Beside = typeof world.objects.beside;
const besideChoice = choice<Beside>(
  'Beside it',
  [
    ['none', 'Nothing'],
    ['layer-2', 'Layer 2\u2019s depth error'],
    ['twin', 'The other kind of maps'],
  ],
  'none',
  (v) => {
    world.objects.beside = v;
    if (v === 'twin') bakeTwin();
    if (v === 'layer-2') colourChoice.querySelector('select')!.value = world.objects.colourBy = 'error';
    void world.objects.paint();
    showSides();
  },
  'beside',
);
function showSides(): void {
  const what = world.objects.beside,
    pair = what === 'twin' ? world.objects.pair() : null;
  const split =
    state.mode === 'look' && !state.playing && (what === 'layer-2' ? world.objects.colourBy === 'error' : pair !== null);
  const words = pair
    ? pair.map((i) => (state.facts[i].central ? 'Central maps' : 'The paper\u2019s maps'))
    : ['Layer 3', 'Layer 2'];
  const turns = split !== world.halved;
  sides.hidden = !split;
  if (split)
    words.forEach((text, i) => {
      sides.children[i].textContent = text;
    });
  world.setSplit(split);
  // Two narrow views frame anew, and so does the wide one after them.
  if (turns) world.frame(pair?.[0] ?? state.selected?.object ?? world.objects.focus, world.direction());
}
on(['mode', 'playing', 'scene', 'selected'], showSides);
onScale(showSides);

// A button that shows hidden parts again, whatever is selected.
const showAll = h(
  'button',
  {
    id: 'show-all',
    hidden: true,
    onclick: () => {
      world.objects.showAll();
      canvas.focus();
    },
  },
  '',
);
world.objects.onLeft = (count) => {
  showAll.hidden = count === 0;
  showAll.textContent = `Show all parts (${count} hidden)`;
};
on(['mode'], () => world.objects.leaveOut(state.mode === 'look'));

const partCard = card('Part', partBox);
partCard.hidden = true;
export const lookPanel = h(
  'div',
  {},
  card(
    'Show',
    colourChoice,
    rangeRow,
    besideChoice,
    choice(
      'Surface',
      [
        ['solid', 'Solid'],
        ['clear', 'See-through'],
        ['wire', 'Wireframe'],
        ['off', 'Hidden'],
      ],
      'solid',
      (v) => {
        world.objects.surfaceAs = v as 'solid';
        void world.objects.paint();
      },
      'surface',
    ),
    showAll,
    h(
      'div',
      { class: 'checks', role: 'group', 'aria-label': 'Drawn as well' },
      check(
        'Bounding superquadrics',
        false,
        (on) => {
          world.objects.withSuperquadrics = on;
          void world.objects.paint();
        },
        'superquadrics',
      ),
      check(
        'Bounding spheres',
        false,
        (on) => {
          world.objects.withSpheres = on;
          void world.objects.paint();
        },
        'spheres',
      ),
      check(
        'Map samples',
        false,
        (on) => {
          world.objects.withSamples = on;
          void world.objects.paint();
        },
        'samples',
      ),
      check(
        'Contact margin',
        false,
        (on) => {
          world.objects.withOffset = on;
          void world.objects.paint();
        },
        'offset',
        'The surface moved out by the stored offset: eq. 12',
      ),
      check(
        'Hidden surface',
        false,
        (on) => {
          world.objects.withHidden = on;
          void world.objects.paint();
        },
        'hidden',
        'What its part\u2019s projection does not see first: Q2 of section 5',
      ),
    ),
  ),
  ...measureCards,
  meetingsCard,
  partCard,
);
on(['scene', 'selected'], () => {
  partCard.hidden = !state.selected;
});
// Choices without an object are disabled.
on(['scene'], () => {
  const colour = lookPanel.querySelector<HTMLSelectElement>('#colour')!;
  if (!saved)
    for (const [kind, there] of [
      ['made-up', state.facts.some((f) => f.cure !== null)],
      ['difference', state.facts.some((f) => f.twin !== null)],
    ] as const) {
      colour.querySelector<HTMLOptionElement>(`option[value=${kind}]`)!.disabled = !there;
      if (!there && colour.value === kind) {
        colour.value = world.objects.colourBy = 'parts';
        void world.objects.paint();
      }
    }
  besideChoice.querySelector<HTMLOptionElement>('option[value=twin]')!.disabled = !state.facts.some(
    (f) => f.twin !== null || (f.hasTriangles && !saved),
  );
});
