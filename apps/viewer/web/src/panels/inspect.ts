// A close look at one point: the answer of each layer of each projection below it, the search for its foot, a section.
import type * as THREE from 'three';
import { digits, fill, h } from '../dom';
import { vector } from '../geometry';
import { fetchBytes, fetchJson, link, saved } from '../net';
import { trouble, wait } from '../notices';
import { readSection, SectionView } from '../section';
import { world } from '../stage';
import { on, state } from '../state';
import { onTheme } from '../theme';
import { card, choice } from './controls';
import { map } from './parts';

interface LayerAnswer {
  layer: string;
  contact: boolean;
  certain: boolean;
  depth: number;
  normal: number[];
  part: number;
  status: string[];
}
interface Answers {
  projection: string;
  layers: LayerAnswer[];
}
/// A sample that a search looked at: its position on the map (0, 1) and in the world (2 to 4), its distance in m (5), I_S (6), the
/// samples between neighbours of its level (7; 0: a step of Newton's method), above 0 where it is the best so far (8).
type Step = number[];
interface Search {
  projector: string;
  contact: boolean;
  proven: boolean;
  wide: boolean;
  footDistance: number;
  mapDistance: number | null;
  depth: number;
  steps: Step[];
}
interface Searches {
  held: boolean;
  grid: number[];
  searches: Search[];
}

let below = 0.002,
  axis = 0,
  projector = 'newton',
  searches: Searches | null = null,
  asked = 0;

const section = new SectionView();
section.colour = (part) => world.objects.colourOf(state.pick?.object ?? 0, part);
onTheme(() => section.draw());
const belowRead = h('output', { for: 's-below' });
const belowSlider = h('input', {
  type: 'range',
  id: 's-below',
  min: '0',
  max: '20',
  step: '0.1',
  value: '2',
  oninput: () => {
    below = Number(belowSlider.value) / 1000;
    showBelow();
    due();
  },
});
function showBelow(): void {
  belowRead.textContent = `${digits(1000 * below)} mm`;
  belowSlider.setAttribute('aria-valuetext', belowRead.textContent);
}
showBelow();
const answers = h('div', { id: 'answers' }),
  searchWords = h('p', { class: 'note', id: 'search-words' }),
  sectionWords = h(
    'p',
    { class: 'note' },
    'Lines: F of the part at 1/16, 1/4, 1 (thick), 4 and 16. Dashed: F = 1 of other parts. Black: the surface that is cut.',
  );
const projectorChoice = choice(
  'Found by',
  [
    ['newton', 'Newton'],
    ['pyramid', 'Pyramid'],
    ['printed', 'As printed'],
    ['off', 'Not shown'],
  ],
  'newton',
  (v) => {
    projector = v;
    showSearch();
  },
  'projector',
);
const searchCard = card('Foot of the point', projectorChoice, searchWords);
const sectionCard = card(
  'Level sets of F',
  choice(
    'Across axis',
    [
      ['0', '1 of the part'],
      ['1', '2 of the part'],
      ['2', '3 of the part'],
      ['off', 'Not shown'],
    ],
    '0',
    (v) => {
      axis = v === 'off' ? -1 : Number(v);
      refresh();
    },
    'section-axis',
  ),
  section.canvas,
  sectionWords,
);
const answersCard = card(
  'Below this point',
  h('label', { class: 'field slider' }, h('span', {}, 'Below'), belowSlider, belowRead),
  answers,
);
export const inspectBox = h('div', { id: 'inspect', hidden: true }, answersCard, searchCard, sectionCard);

/// The point that the layers answer, in the world; null where no point is picked.
function point(): THREE.Vector3 | null {
  return state.pick && state.pick.point.clone().addScaledVector(state.pick.normal, -below);
}
const where = (p: THREE.Vector3): string =>
  `at=${p
    .toArray()
    .map((x) => x.toFixed(7))
    .join('_')}`;

let timer = 0;
function due(): void {
  clearTimeout(timer);
  timer = window.setTimeout(refresh, 60);
}

/// Fetches the answers at the point. Replies about an earlier point are dropped.
function refresh(): void {
  const p = point(),
    pick = state.pick,
    f = pick ? state.facts[pick.object] : undefined,
    request = ++asked;
  inspectBox.hidden = !p || !f || !!saved;
  searches = null;
  showSearch();
  if (!p || !pick || !f || saved) {
    section.show(null, -1, null);
    world.traces.setSection(null);
    return;
  }
  const still = () => request === asked,
    fail = (e: unknown) => {
      if (still()) trouble(e);
    };
  const twin = f.twin === null ? undefined : state.facts[f.twin],
    shift = twin && vector(twin.position).sub(vector(f.position));
  if (f.edited) fill(answers, h('p', { class: 'note' }, 'Bake the edited parts to query them.'));
  else
    Promise.all([
      fetchJson<Answers>(`/api/object/${pick.object}/at/answers?${where(p)}`),
      twin && shift ? fetchJson<Answers>(`/api/object/${f.twin}/at/answers?${where(p.clone().add(shift))}`) : null,
    ])
      .then(([own, other]) => {
        if (still()) showAnswers(own, other);
      })
      .catch(fail);
  searchCard.hidden = f.central || f.edited;
  if (!f.central && !f.edited)
    fetchJson<Searches>(`/api/object/${pick.object}/search/${pick.part}?${where(p)}`)
      .then((s) => {
        if (still()) {
          searches = s;
          showSearch();
        }
      })
      .catch(fail);
  section.canvas.hidden = sectionWords.hidden = axis < 0;
  if (axis < 0) {
    section.show(null, -1, null);
    world.traces.setSection(null);
    return;
  }
  fetchBytes(`/api/object/${pick.object}/section/${pick.part}/${axis}?${where(p)}`)
    .then((data) => {
      if (!still()) return;
      const s = readSection(data);
      section.show(s, pick.part, p);
      world.traces.setSection(state.mode === 'look' ? s : null);
    })
    .catch(fail);
}

function showAnswers(own: Answers, other: Answers | null): void {
  const both = other ? [own, other].sort((a, b) => (a.projection < b.projection ? -1 : 1)) : [own];
  const row = (maps: string, a: LayerAnswer, first: boolean) =>
    h(
      'tr',
      { title: a.status.join('; ') },
      first ? h('th', { scope: 'row', rowSpan: a.layer === 'exact' ? 1 : both.length }, a.layer) : null,
      both.length > 1 ? h('td', {}, a.layer === 'exact' ? 'both' : maps) : null,
      h(
        'td',
        { class: a.contact ? 'inside' : 'free' },
        `${a.contact ? 'inside' : 'free'}${a.certain ? ' ✓' : ''}${a.status.length ? ' *' : ''}`,
      ),
      h('td', { class: 'number' }, a.contact ? (1000 * a.depth).toFixed(3) : '–'),
      h(
        'td',
        { class: 'number' },
        a.contact && a.normal.some((x) => x) ? a.normal.map((x) => x.toFixed(2).replace('0.', '.')).join(' ') : '–',
      ),
    );
  const layers = [...new Set(both.flatMap((b) => b.layers.map((a) => a.layer)))];
  const notes = [...new Set(both.flatMap((b) => b.layers.flatMap((a) => a.status)))];
  const f = state.facts[state.pick!.object];
  fill(
    answers,
    h(
      'table',
      { class: 'answers' },
      h(
        'thead',
        {},
        h(
          'tr',
          {},
          ...['Layer', ...(both.length > 1 ? ['Maps'] : []), 'Verdict', 'mm deep', 'Normal'].map((t) =>
            h('th', { scope: 'col' }, t),
          ),
        ),
      ),
      // The exact layer stands once: both projections have the same triangles.
      h(
        'tbody',
        {},
        ...layers.flatMap((layer) =>
          (layer === 'exact' ? [both[0]] : both).flatMap((b, i) => {
            const a = b.layers.find((x) => x.layer === layer);
            return a ? [row(b.projection, a, i === 0)] : [];
          }),
        ),
      ),
    ),
    h(
      'p',
      { class: 'note' },
      `✓: proven.${notes.length ? ` *: ${notes.join('; ')}.` : ''} Maps: ${both.length > 1 ? 'central and normal (the paper’s), of the same mesh' : own.projection === 'normal' ? 'normal, the paper’s own' : 'central'}.`,
    ),
    both.length === 1 &&
      f.hasTriangles &&
      h(
        'button',
        {
          id: 'rebake',
          onclick: () => {
            wait(`Baking ${f.name} with the ${own.projection === 'normal' ? 'central' : 'paper’s'} maps …`);
            link.say({ say: 'rebake', object: state.pick!.object });
          },
        },
        own.projection === 'normal' ? 'Bake with central maps, too' : 'Bake with the paper’s maps, too',
      ),
  );
}

/// The steps at which a level of the grid ended; every step of Newton's method.
function ends(steps: Step[]): Set<Step> {
  const out = new Set<Step>();
  let best: Step | null = null;
  steps.forEach((s, i) => {
    if (s[8] > 0) best = s;
    if (best && (s[7] === 0 || steps[i + 1]?.[7] !== s[7])) out.add(best);
  });
  return out;
}

/// Shows the search over the map, in the scene, and in words.
function showSearch(): void {
  const found = searches?.searches.find((s) => s.projector === projector),
    p = point(),
    pick = state.pick;
  const steps = found && state.mode === 'look' ? found.steps : [],
    best = ends(steps);
  const mapped = pick && state.selected?.object === pick.object && state.selected.part === pick.part;
  map.setSteps(mapped ? steps.map((s) => ({ x: s[0], y: s[1], stride: s[7], best: best.has(s) })) : []);
  const at = (s: Step) => vector(s, 2),
    path = [...best].map(at);
  world.traces.setSearch(steps.map(at), path, p);
  section.setFoot(path.at(-1) ?? null);
  if (!searches) {
    searchWords.textContent = '';
    return;
  }
  if (!searches.held) {
    searchWords.textContent = 'The superquadric of this part does not hold the point.';
    return;
  }
  if (!found) {
    searchWords.textContent = '';
    return;
  }
  const last = found.steps.filter((s) => s[8] > 0).at(-1),
    levels = [...new Set(found.steps.map((s) => s[7]))].filter((s) => s > 0);
  const count =
    found.projector === 'newton' && !levels.length
      ? `${found.steps.length - 1} steps of Newton’s method`
      : `${found.steps.filter((s) => s[7] > 0).length} samples looked at, every ${levels.join(', ')} of ${searches.grid.join(' × ')}`;
  searchWords.textContent = `${count}${found.wide ? '; its window did not hold the foot: the whole surface was searched' : ''}. ${last ? `Foot ${digits(1000 * last[5])} mm away, I_S ${last[6].toFixed(4)}. ` : ''}The map has ${found.mapDistance === null ? 'no surface on that ray' : `the surface ${digits(1000 * found.mapDistance)} mm below the superquadric`}: ${found.contact ? `inside, ${digits(1000 * found.depth)} mm deep` : 'free'}${found.proven ? '' : ', not proven'}.`;
}

on(['selected'], showSearch);
on(['pick', 'scene', 'mode'], () => {
  if (state.mode === 'look') refresh();
  else {
    world.traces.setSection(null);
    world.traces.setSearch([], [], null);
  }
});

/// For tests.
export const inspected = () => ({ searches, point: point()?.toArray() ?? null });
