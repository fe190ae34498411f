// The point that is clicked, or reached by keys: its numbers beside the panel, and its label on the picture.
import { announce, digits, fill, h } from '../dom';
import { lookAt } from '../first';
import { pointInFile } from '../file_point';
import { vector } from '../geometry';
import { panel } from '../layout';
import { link } from '../net';
import { MISS } from '../colours';
import type { Hit } from '../objects';
import { canvas, HELD, hint, legend, MISSED, onScale, stage, world } from '../stage';
import { changed, on, state } from '../state';
import { viewWords } from '../where';
import { card } from './controls';
import { inspectBox } from './inspect';
import { lookFrom, measuring, VIEWS } from './measure';
import { map, select } from './parts';

const numbers = h('dl', { class: 'numbers', id: 'numbers' });

/// The numbers of the picked point, and the program's answers there.
export const pickBox = card('Point', numbers),
  answersBox = h('div', {}, inspectBox);
on(['mode', 'playing'], () => {
  pickBox.hidden = answersBox.hidden = state.mode !== 'look' || state.playing;
});
function setNumbers(rows: [string, string][]): void {
  numbers.replaceChildren(
    ...(rows.length ? rows : [['Nothing yet', 'click the object for its numbers']]).flatMap(([k, v]) => [
      h('dt', {}, k),
      h('dd', {}, v),
    ]),
  );
}

/// A label beside the point that was clicked. It is hidden from screen readers, because the panel says the same.
const tag = h('div', { class: 'pick-tag', id: 'pick-tag', hidden: true, 'aria-hidden': 'true' });
stage.append(tag);
function showTag(): void {
  tag.hidden = state.mode !== 'look' || state.playing || !state.pick;
  if (tag.hidden) return;
  const { x, y } = world.pixel(state.pick!.point),
    { x: wide, y: high } = world.size;
  tag.hidden = x < 0 || y < 0 || x > wide || y > high;
  // The label stands above the point, else below it, and never covers it.
  const { offsetWidth: w, offsetHeight: h } = tag,
    above = y - h - 14;
  tag.style.transform = `translate(${Math.max(Math.min(x - 0.5 * w, wide - w - 6), 6).toFixed(0)}px, ${(above < 6 ? y + 14 : above).toFixed(0)}px)`;
}
world.controls.addEventListener('change', showTag);
new ResizeObserver(() => requestAnimationFrame(showTag)).observe(stage);
on(['pick', 'mode', 'playing', 'scene'], showTag);

function click(hit: Hit | null): void {
  if (state.playing) return; // a click would give the hidden object away
  hint.hidden = true;
  panel.scrollTop = 0;
  state.pick = hit;
  if (!hit) {
    select(-1, -1);
    lookAt(-1);
    world.tool.mark(null);
    setNumbers([]);
    changed('pick');
    return;
  }
  world.tool.mark(hit.point);
  const f = state.facts[hit.object];
  // The clicked object comes forward where objects overlap on the screen, but not between the two clicks of a measurement.
  const forward = world.objects.focus !== hit.object && !measuring() && world.crowded(hit.object);
  select(hit.object, hit.part);
  if (forward || world.objects.focus >= 0) lookAt(hit.object);
  if (forward) world.frame(hit.object, world.direction());
  const error = world.objects.fieldAt(hit.object, 'error', hit.triangle);
  const rows: [string, string][] = [
    ['Object', f.name],
    ['Part', `${hit.part}: ${f.parts[hit.part].name}`],
    ['Point', `${pointInFile(f, hit.point)} in the file’s units`],
  ];
  if (hit.triangle >= 0)
    rows.push(
      ['Triangle', String(hit.triangle)],
      [
        'Normal',
        hit.normal
          .toArray()
          .map((x) => x.toFixed(2))
          .join(', '),
      ],
    );
  if (error !== undefined)
    rows.push([
      'Depth error',
      error === MISS
        ? `missed: ${MISSED}.${f.exact ? ` ${HELD}` : ''}`
        : error < 0
          ? 'too thin to say'
          : `${digits(error)} % of its size`,
    ]);
  for (const kind of ['protrusion', 'curvature']) {
    const v = world.objects.fieldAt(hit.object, kind, hit.triangle);
    if (v !== undefined) rows.push([kind[0].toUpperCase() + kind.slice(1), digits(v)]);
  }
  setNumbers(rows);
  const value = rows.slice(3).find(([k]) => k !== 'Triangle' && k !== 'Normal');
  fill(
    tag,
    h('strong', {}, f.parts[hit.part].name),
    ` ${value ? `${value[0].toLowerCase()} ${value[1].replace(/:.*/, '')}` : pointInFile(f, hit.point)}`,
  );
  changed('pick');
  announce(
    rows
      .slice(0, 2)
      .map((r) => r[1])
      .join(', '),
  );
}

/// Forgets the picked point, whose object is gone or has changed.
export function dropPick(): void {
  state.pick = null;
  world.tool.mark(null);
  setNumbers([]);
  changed('pick');
}

// The worst depth error; a click brings the camera there.
const worstButton = h(
  'button',
  {
    id: 'worst',
    class: 'small',
    hidden: true,
    onclick: () => {
      const worst = world.objects.worst();
      if (!worst) return;
      click(worst.hit);
      world.closeTo(worst.hit.object, worst.hit.point, worst.hit.normal);
    },
  },
  '',
);
legend.append(worstButton);
onScale(() => {
  const worst = world.objects.colourBy === 'error' ? world.objects.worst() : null;
  worstButton.hidden = !worst;
  if (worst)
    worstButton.textContent = `Worst triangle: ${worst.value === MISS ? 'missed' : `${digits(worst.value)} %`}, ${state.facts[worst.hit.object].name}: show it`;
});

let pressed: { x: number; y: number } | null = null;
canvas.addEventListener('pointerdown', (e) => {
  pressed = { x: e.clientX, y: e.clientY };
  if (state.mode === 'look') hint.hidden = true;
});
canvas.addEventListener('pointerup', (e) => {
  if (state.mode === 'look' && pressed && Math.hypot(e.clientX - pressed.x, e.clientY - pressed.y) < 4)
    click(world.cast(...world.onCanvas(e).toArray()));
  pressed = null;
});
canvas.addEventListener('pointermove', (e) => {
  if (state.mode !== 'look' || pressed || !state.selected || state.facts[state.selected.object]?.edited) return;
  const hit = world.cast(...world.onCanvas(e).toArray());
  if (hit && hit.object === state.selected.object && hit.part === state.selected.part) {
    map.show(hit.point);
    world.tool.mark(hit.point);
  }
});
document.addEventListener('keydown', (e) => {
  if (
    state.mode !== 'look' ||
    !state.selected ||
    !(e.ctrlKey || e.metaKey) ||
    e.key.toLowerCase() !== 'z' ||
    document.activeElement instanceof HTMLInputElement
  )
    return;
  const f = state.facts[state.selected.object];
  if (!(e.shiftKey ? f?.canRedo : f?.canUndo)) return;
  e.preventDefault();
  link.say({ say: e.shiftKey ? 'redo' : 'undo', object: state.selected.object });
});
// The side that a turn by keys ends at is said once the keys rest.
let viewDue = 0;
function sayView(): void {
  clearTimeout(viewDue);
  viewDue = window.setTimeout(() => {
    if (state.mode === 'look') announce(`Seen ${viewWords()}.`);
  }, 400);
}
// The keys that do the same without a pointer.
canvas.addEventListener('keydown', (e) => {
  if (state.mode !== 'look' || e.ctrlKey || e.altKey || e.metaKey) return;
  const step = e.shiftKey ? Math.PI / 90 : Math.PI / 24;
  const turns: Record<string, [number, number]> = {
    ArrowLeft: [-step, 0],
    ArrowRight: [step, 0],
    ArrowUp: [0, -step],
    ArrowDown: [0, step],
  };
  if (turns[e.key]) {
    world.turn(...turns[e.key]);
    sayView();
  } else if (e.key === '+' || e.key === '=') world.zoom(0.87);
  else if (e.key === '-') world.zoom(1.15);
  else if (e.key === 'Home') {
    lookAt(-1);
    world.frame();
    announce('All objects are in sight.');
  } else if (/^[1-9]$/.test(e.key) && VIEWS[Number(e.key) - 1]) lookFrom(Number(e.key) - 1);
  else if (e.key === 'Enter') {
    const hit = world.cast(0, 0);
    if (!hit) announce('Nothing in the middle of the view.');
    click(hit);
  } else return;
  e.preventDefault();
  hint.hidden = true;
});
map.onPoint = (p) => world.tool.mark(p);
map.onPick = (p) => {
  const s = state.selected,
    f = s ? state.facts[s.object] : undefined;
  if (state.mode !== 'look' || !s || !f) return;
  const part = f.parts[s.part];
  // Without triangles only the map has the surface; its normal is then taken from the middle of the part.
  click(
    f.hasTriangles || !part
      ? world.objects.nearest(s.object, p)
      : { ...s, triangle: -1, point: p.clone(), normal: p.clone().sub(vector(part.sphere)).normalize() },
  );
};
setNumbers([]);
// A picked point is dropped when its object is gone or has other parts.
let picked = '';
const nameOf = (object: number): string => {
  const f = state.facts[object];
  return f ? `${f.id}/${f.revision}` : '';
};
on(['pick'], () => {
  picked = state.pick ? nameOf(state.pick.object) : '';
});
on(['scene'], () => {
  if (state.pick && nameOf(state.pick.object) !== picked) dropPick();
});
