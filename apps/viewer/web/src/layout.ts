// The page's two sides: the stage with its charts, and the panel, whose width is the user's; on a narrow screen the panel is a sheet
// that slides over the stage.
import { h } from './dom';

const LEAST = 280,
  LARGEST = 640,
  STEP = 20; // px
const narrow = matchMedia('(max-width: 900px)');

export const main = h('main', {});
export const panel = h('div', { class: 'panel', id: 'panel', role: 'tabpanel', tabIndex: -1 });

function widen(to: number): void {
  const width = Math.round(Math.min(Math.max(to, LEAST), Math.min(LARGEST, 0.6 * innerWidth)));
  main.style.setProperty('--panel', `${width}px`);
  edge.setAttribute('aria-valuenow', String(width));
}
const wide = (): number => panel.getBoundingClientRect().width;
export const edge = h('div', {
  class: 'edge',
  role: 'separator',
  tabIndex: 0,
  'aria-orientation': 'vertical',
  'aria-label': 'Width of the panel',
  'aria-valuemin': String(LEAST),
  'aria-valuemax': String(LARGEST),
  'aria-valuenow': '372',
  'aria-controls': 'panel',
  onpointerdown: (e: Event) => edge.setPointerCapture((e as PointerEvent).pointerId),
  onpointermove: (e: Event) => {
    if (edge.hasPointerCapture((e as PointerEvent).pointerId)) widen(innerWidth - (e as PointerEvent).clientX);
  },
  onkeydown: (e: Event) => {
    const by = { ArrowLeft: STEP, ArrowRight: -STEP }[(e as KeyboardEvent).key];
    if (!by) return;
    e.preventDefault();
    widen(wide() + by);
  },
});

export const sheet = h('button', {
  class: 'sheet',
  id: 'sheet',
  'aria-controls': 'panel',
  onclick: () => openSheet(main.dataset.sheet !== 'open'),
});
/// Opens or closes the sheet of a narrow screen; a wide screen shows the panel always.
export function openSheet(open: boolean): void {
  main.dataset.sheet = open ? 'open' : 'closed';
  sheet.setAttribute('aria-expanded', String(open));
  sheet.textContent = open ? 'Less ▾' : 'Settings and numbers ▴';
  panel.inert = narrow.matches && !open;
}
narrow.addEventListener('change', () => openSheet(!narrow.matches));
openSheet(false);
panel.inert = narrow.matches;
