// The tree of objects and their parts: names, hide, alone, move, remove and take back.
import { css } from '../colours';
import { announce, bytes, digits, h } from '../dom';
import { lookAt } from '../first';
import type { ObjectFacts } from '../messages';
import { setMode } from '../modes';
import { link, saved } from '../net';
import { world } from '../stage';
import { changed, on, state } from '../state';
import { count, cureDetails, cureWords } from './models';
import { move, movedNow, moveFields } from './move';
import { removeObject, select } from './parts';

export const factsBox = h('div', { class: 'facts', id: 'facts' });
const open = new Set<number>(); ///< the ids of the objects whose parts are listed

/// Hides an object or shows it again; a saved page has no program that would do it.
function hide(object: number, yes: boolean): void {
  if (state.facts[object].hidden === yes) return;
  if (!saved) {
    link.say({ say: 'hide', object, on: yes });
    return;
  }
  state.facts[object].hidden = yes;
  void world.setScene(state.facts);
  changed('scene');
}
/// Shows one object alone, or all again where it is alone.
function alone(object: number): void {
  const is = state.facts.every((f, i) => f.hidden === (i !== object));
  state.facts.forEach((_, i) => hide(i, !is && i !== object));
  if (!is && !world.sees(object)) world.frame(object, world.direction());
  announce(is ? 'All objects are shown.' : `${state.facts[object].name} alone is shown.`);
}

const small = (id: string, text: string, label: string, act: () => void, pressed?: boolean) =>
  h(
    'button',
    { class: 'small', id, 'aria-label': label, 'aria-pressed': pressed === undefined ? undefined : String(pressed), onclick: act },
    text,
  );

function partsOf(f: ObjectFacts, i: number): HTMLElement {
  const list = h('ol', { class: 'parts', start: 0, hidden: !open.has(f.id) });
  if (open.has(f.id))
    list.append(
      ...f.parts.map((p, k) => {
        const left = world.objects.isLeft(i, k),
          chosen = state.selected?.object === i && state.selected.part === k;
        return h(
          'li',
          {},
          h(
            'button',
            { class: 'part', id: `part-${f.id}-${k}`, 'aria-pressed': String(chosen), onclick: () => select(i, k) },
            h('i', { style: `background:${css(world.objects.colourOf(i, k))}`, 'aria-hidden': 'true' }),
            p.name,
            p.certified ? '' : ' (not certified)',
          ),
          state.mode === 'look' &&
            small(`hide-part-${f.id}-${k}`, left ? 'Show' : 'Hide', `${left ? 'Show' : 'Hide'} ${p.name}`, () => {
              world.objects.showPart(i, k, left);
              showTree();
            }),
        );
      }),
    );
  return list;
}

/// The figures that the bake gives an object.
function figures(f: ObjectFacts): HTMLElement[] {
  const certified = f.parts.filter((p) => p.certified).length,
    wrong = f.measured.missed + f.measured.false > 0;
  const title = `Layer 3 on ${f.measured.points} points: ${f.measured.missed} missed, ${f.measured.false} made up, 0.5 % of its size or more from the surface; depth error median ${digits(f.measured.depthMedian, 2)} %, 99th percentile ${digits(f.measured.depthP99, 2)} % of its size: R_max, the largest distance between two vertices`;
  const words = f.edited
    ? 'Bytes, certificates and errors are told once the parts are baked.'
    : `${certified === f.parts.length ? '✓ all certified' : `✗ ${certified} certified`}; 99 % of depths within ${digits(f.measured.depthP99, 2)} %${wrong ? `, ✗ layer 3 missed ${f.measured.missed} and made up ${f.measured.false} of ${f.measured.points.toLocaleString('en')} points` : ''}`;
  return [
    h(
      'span',
      {},
      `${count(f.parts.length)}, ${f.edited ? '' : `${bytes(f.bytes.total)}, `}${f.triangles.toLocaleString('en')} faces`,
    ),
    h('span', {}, `${f.central ? 'central maps' : 'the paper’s maps (normal)'}${f.exact ? ' and triangles' : ''}`),
    ...(f.cure ? [h('span', { class: 'cure', title: cureDetails(f) }, cureWords(f))] : []),
    h('span', { class: wrong || certified < f.parts.length ? 'warn' : '', title }, words),
  ];
}

function row(f: ObjectFacts, i: number): HTMLElement {
  const current = state.selected?.object === i,
    moves = movedNow() === f.id,
    several = state.facts.length > 1;
  const name = h(
    'button',
    {
      class: 'object',
      id: `object-${f.id}`,
      'aria-pressed': String(current),
      onclick: () => {
        select(i, -1);
        lookAt(i);
        if (!f.hidden) world.frame(i);
      },
    },
    f.name + (f.edited ? ' (edited, not baked)' : ''),
  );
  const acts = h(
    'div',
    { class: 'row acts', role: 'group', 'aria-label': f.name },
    small(`hide-${f.id}`, f.hidden ? 'Show' : 'Hide', `${f.hidden ? 'Show' : 'Hide'} ${f.name}`, () => {
      hide(i, !f.hidden);
      announce(`${f.name} is ${f.hidden ? 'shown' : 'hidden'}.`);
    }),
    several &&
      small(
        `alone-${f.id}`,
        'Alone',
        `${f.name} alone`,
        () => alone(i),
        state.facts.every((g, k) => g.hidden === (k !== i)),
      ),
    !saved &&
      small(
        `move-${f.id}`,
        'Move',
        `Move ${f.name}`,
        () => {
          move(moves ? -1 : f.id);
          if (!moves) setMode('look');
          showTree();
        },
        moves,
      ),
    small(
      `parts-${f.id}`,
      `Parts ${open.has(f.id) ? '▾' : '▸'}`,
      `Parts of ${f.name}`,
      () => {
        if (!open.delete(f.id)) open.add(f.id);
        showTree();
      },
      open.has(f.id),
    ),
    !saved && small(`remove-${f.id}`, '✕', `Remove ${f.name}`, () => removeObject(i)),
  );
  const rename =
    current &&
    !saved &&
    h('input', {
      type: 'text',
      id: 'object-name',
      value: f.name,
      maxLength: 60,
      'aria-label': 'Name of the object',
      onchange: (e: Event) => {
        const to = (e.target as HTMLInputElement).value.trim().slice(0, 60);
        if (to) link.say({ say: 'rename', object: i, name: to });
      },
    });
  return h(
    'li',
    { class: f.hidden ? 'gone' : '' },
    name,
    acts,
    ...figures(f),
    rename && h('label', { class: 'field' }, h('span', {}, 'Name'), rename),
    moves && moveFields(f),
    partsOf(f, i),
  );
}

function removeAll(): void {
  const { length } = state.facts;
  select(-1, -1);
  for (let i = length - 1; i >= 0; --i) link.say({ say: 'remove', object: i });
  announce(`${length} objects removed. Undo takes back one after the other.`);
}

function showTree(): void {
  factsBox.hidden = state.mode === 'recognise' || state.mode === 'dress';
  const held =
      document.activeElement instanceof HTMLElement && factsBox.contains(document.activeElement) ? document.activeElement.id : '',
    at = factsBox.querySelector('.objects')?.scrollTop ?? 0;
  const { facts } = state;
  factsBox.replaceChildren(
    h(
      'section',
      { class: 'card' },
      h('h2', {}, facts.length === 1 ? 'Model' : `Models (${facts.length})`),
      facts.length
        ? h('ul', { class: 'objects' }, ...facts.map(row))
        : h('p', {}, state.loading ? 'Reading and baking …' : 'Nothing is open: drop a mesh, or press Open.'),
      !saved &&
        h(
          'div',
          { class: 'row wrap' },
          facts.length > 1 && h('button', { id: 'remove-all', onclick: removeAll }, 'Remove all'),
          state.removed !== null &&
            h('button', { id: 'restore', onclick: () => link.say({ say: 'restore' }) }, `Undo: ${state.removed} comes back`),
        ),
    ),
  );
  const list = factsBox.querySelector('.objects');
  if (list) list.scrollTop = at;
  if (held) (document.getElementById(held) ?? document.getElementById('restore'))?.focus();
}
on(['scene', 'selected', 'playing', 'mode'], showTree);
showTree();
