// The selected part: its name, its map, its edits.
import { css } from '../colours';
import { digits, fill, h } from '../dom';
import { MapView } from '../map';
import type { Bound, Bounds, Feet, ObjectFacts } from '../messages';
import { link, saved } from '../net';
import { trouble, undoable, wait } from '../notices';
import { world } from '../stage';
import { changed, on, state } from '../state';
import { card, check } from './controls';

export const partBox = h('div', { id: 'part' });
export const map = new MapView();
export const mapCard = card(
  'Map of the part',
  map.element,
  check('Grey, as in Fig. 4c', false, (on) => map.setGrey(on), 'map-grey'),
);

/// Selects a part, or an object where part is -1; object -1: nothing.
export function select(object: number, part: number): void {
  state.selected = object < 0 ? null : { object, part };
  if (object >= 0 && !state.frame?.contacts) state.touched = -1; // what is selected now is meant, not what was touched before
  world.objects.select(object, part);
  changed('selected');
}

/// Removes an object; the notice and the list of models take it back.
export function removeObject(object: number): void {
  const { name } = state.facts[object];
  if (state.selected?.object === object) select(-1, -1);
  link.say({ say: 'remove', object });
  undoable(`${name} is removed.`, () => link.say({ say: 'restore' }));
}

let chosenOther = -1,
  cutStep = 0.004;
const CUT_STEPS: [number, string][] = [
  [0, 'a row'],
  [0.002, '2 mm'],
  [0.004, '4 mm'],
  [0.01, '10 mm'],
];

/// Volumes over the solid's and support excess of each bound: of a part, or of the union of all and the whole.
function boundsTable(f: ObjectFacts, bounds: Bounds | null | undefined, of: string): HTMLElement | null {
  if (!bounds) return null;
  const row = (name: string, b: Bound) =>
    h(
      'tr',
      {},
      h('th', { scope: 'row' }, name),
      h('td', { class: 'number' }, b.volume_ratio === null ? '–' : b.volume_ratio.toFixed(2)),
      h('td', { class: 'number' }, digits(1000 * f.metresPerUnit * b.support_excess)),
      h('td', { class: 'number' }, b.support_excess_percent.toFixed(2)),
    );
  return h(
    'table',
    {
      class: 'answers',
      title:
        'How far each bound reaches: its volume over the solid’s, and its support excess, the greatest distance of its points from the convex hull of the surface. Layer 1 takes both.',
    },
    h(
      'thead',
      {},
      h('tr', {}, ...[`Bounds of ${of}`, 'Volume', 'Excess, mm', '% of R_max'].map((t) => h('th', { scope: 'col' }, t))),
    ),
    h('tbody', {}, row('Superquadric', bounds.superquadric), row('Polytope', bounds.polytope), row('Both', bounds.both)),
  );
}

function showPart(): void {
  const s = state.selected,
    f = s ? state.facts[s.object] : undefined;
  if (!s || !f) {
    partBox.replaceChildren();
    map.clear('Select a part: click the object.');
    return;
  }
  const say = (name: string, more: object = {}) => link.say({ say: name, object: s.object, ...more });
  const edits = h('div', { class: 'row wrap', role: 'group', 'aria-label': 'Edit the parts' });
  const p = f.parts[s.part];
  if (p && !saved) {
    const neighbours = p.neighbours.length ? p.neighbours : f.parts.map((_, i) => i).filter((i) => i !== s.part);
    const other = h(
      'select',
      { id: 'other', 'aria-label': 'The other part' },
      ...neighbours.map((i) => h('option', { value: String(i) }, f.parts[i].name)),
    );
    if (neighbours.includes(chosenOther)) other.value = String(chosenOther);
    other.addEventListener('change', () => {
      chosenOther = Number(other.value);
    });
    const by = h(
      'select',
      { id: 'by', 'aria-label': 'How far the cut moves' },
      ...CUT_STEPS.map(([v, t]) => h('option', { value: String(v) }, t)),
    );
    by.value = String(cutStep);
    by.addEventListener('change', () => {
      cutStep = Number(by.value);
    });
    const move = (part: number, into: number) => {
      chosenOther = Number(other.value);
      wait('Moving the cut …');
      say('movecut', { part, other: into, distance: cutStep });
    };
    edits.append(
      h(
        'button',
        {
          id: 'split',
          onclick: () => {
            wait('Cutting …');
            say('split', { part: s.part });
          },
        },
        'Split',
      ),
    );
    if (f.parts.length > 1)
      edits.append(
        h(
          'fieldset',
          {},
          h('legend', {}, 'Its cut with'),
          other,
          h(
            'div',
            { class: 'row wrap' },
            h('button', { id: 'grow', onclick: () => move(s.part, Number(other.value)) }, 'Push out'),
            h('button', { id: 'shrink', onclick: () => move(Number(other.value), s.part) }, 'Pull in'),
            by,
            h(
              'button',
              {
                id: 'merge',
                onclick: () => {
                  wait('Joining …');
                  say('merge', { part: s.part, other: Number(other.value) });
                },
              },
              'Merge',
            ),
          ),
        ),
      );
    edits.append(
      h(
        'button',
        {
          id: 'refit',
          onclick: () => {
            wait('Fitting …');
            say('refit', { part: s.part });
          },
        },
        'Refit',
      ),
    );
  }
  if (p)
    edits.append(
      h('button', { id: 'isolate', onclick: () => world.objects.isolate(s.object, s.part) }, 'Show it alone'),
      h(
        'button',
        {
          id: 'hide-part',
          onclick: () => {
            world.objects.showPart(s.object, s.part, false);
            state.pick = null;
            world.tool.mark(null);
            changed('pick');
          },
        },
        'Hide it',
      ),
      h('button', { id: 'show-parts', onclick: () => world.objects.isolate(s.object, -1) }, 'Show all'),
    );
  if (!saved)
    edits.append(
      h('button', { id: 'undo', disabled: !f.canUndo, onclick: () => say('undo') }, 'Undo'),
      h('button', { id: 'redo', disabled: !f.canRedo, onclick: () => say('redo') }, 'Redo'),
    );
  if (f.edited) edits.append(h('button', { id: 'bake', class: 'primary', onclick: () => say('bake') }, 'Bake the edited parts'));
  if (!saved) edits.append(h('button', { id: 'remove', onclick: () => removeObject(s.object) }, 'Remove object'));
  const name =
    p &&
    h('input', {
      type: 'text',
      id: 'part-name',
      value: p.name,
      maxLength: 60,
      'aria-label': 'Name of the part',
      disabled: !!saved,
      onchange: (e: Event) => say('name', { part: s.part, name: (e.target as HTMLInputElement).value.trim().slice(0, 60) }),
    });
  const list = h(
    'details',
    {},
    h('summary', {}, `All ${f.parts.length} parts`),
    h(
      'ol',
      { class: 'parts', start: 0 },
      ...f.parts.map((q, i) =>
        h(
          'li',
          {},
          h(
            'button',
            { class: 'part', 'aria-pressed': String(i === s.part), onclick: () => select(s.object, i) },
            h('i', { style: `background:${css(world.objects.colourOf(s.object, i))}`, 'aria-hidden': 'true' }),
            q.name,
            q.certified ? '' : ' (not certified)',
          ),
        ),
      ),
    ),
  );
  fill(
    partBox,
    name && h('label', { class: 'field' }, h('span', {}, 'Part'), name),
    p &&
      h(
        'p',
        { class: 'note' },
        `${p.triangles.toLocaleString('en')} triangles, ${digits(p.area, 2)} % of the surface; half axes ${p.a.map((x) => digits(1000 * x)).join(' × ')} mm, exponents ${p.eps.map((x) => digits(x, 2)).join(', ')}${p.taper.some((t) => t) ? ', tapered' : ''}${p.bend ? ', bent' : ''}; ${p.certified ? `proven to hold its surface (F ≤ ${digits(p.largestF ?? 0, 4)})` : 'not proven to hold its surface'}`,
      ),
    p ? boundsTable(f, p.bounds, 'the part') : boundsTable(f, f.bounds, 'all parts'),
    edits,
    list,
  );
  if (!p) map.clear('Select a part: click the object.');
  else if (saved) map.clear('The map stays with the program.');
  else if (f.edited) map.clear('Edited parts have a map once they are baked.');
  else showMap(s.object, s.part);
}

function showMap(object: number, part: number): void {
  const f = state.facts[object];
  map
    .load(object, part, `${f.id}/${f.revision}`, [
      f.parts[part].name,
      state.mode === 'look' ? 'Point at it, click it.' : 'Red: the feet of the contacts, larger where they are deeper.',
    ])
    .catch((e) => trouble(e));
}

/// Shows the map: in Look the selected part's, in Touch the map of the part that has most contacts.
function showMapCard(): void {
  mapCard.hidden =
    state.playing ||
    (saved && state.mode === 'touch') ||
    (state.mode !== 'touch' && (state.mode !== 'look' || !state.selected || state.selected.part < 0));
  if (mapCard.hidden) return;
  map.setFeet([]);
  if (state.mode === 'look') showPart();
  else map.clear('Touch an object: here is the map of the touched part, and on it the feet of the contacts.');
}

let feetPart = -1;
export function showFeet({ object, feet }: Feet): void {
  if (mapCard.hidden || saved || state.mode !== 'touch') return;
  const of = (part: number) => feet.filter((f) => f.part === part);
  const f = state.facts[object];
  if (!f || f.edited || !feet.length) {
    map.setFeet([]);
    return;
  }
  const counts = new Map<number, number>();
  for (const { part } of feet) counts.set(part, (counts.get(part) ?? 0) + 1);
  const [most] = [...counts].sort((a, b) => b[1] - a[1])[0];
  // At a border the map changes only when the other part has twice as many contacts.
  if (2 * (counts.get(feetPart) ?? 0) < (counts.get(most) ?? 0)) feetPart = most;
  showMap(object, feetPart);
  map.setFeet(of(feetPart));
}

on(['scene', 'selected'], showPart);
on(['scene', 'selected', 'mode', 'playing'], showMapCard);
