// Meshes and models that are opened, saved, and linked to.
import { announce, fill, h, save } from '../dom';
import { setMode } from '../modes';
import { openSheet } from '../layout';
import type { Progress, Verdict } from '../messages';
import { fetchBytes, link, saved, upload } from '../net';
import { trouble } from '../notices';
import { world } from '../stage';
import { copyLink } from '../session';
import { on, state } from '../state';
import { choice, folded } from './controls';
import { costume } from './dress';
import { select } from './parts';
import { openRecording } from './recording';
import { pageButton } from './share';

/// The program's decisions about a file, in words.
const DECISIONS: Record<string, string> = {
  ACCEPT: 'Taken as it is',
  REPAIRED: 'Taken, with repairs',
  CLOSED: 'Taken, its holes closed',
  WRAPPED: 'Taken, wrapped in a closed surface',
  REFUSED: 'Not taken',
};
const decision = (v: Verdict): string => `${DECISIONS[v.verdict] ?? v.verdict}${v.code ? ` (${v.code})` : ''}`;

/// The verdict on a file.
export const dialog = h('section', {
  class: 'card verdict',
  id: 'verdict',
  hidden: true,
  tabIndex: -1,
  'aria-label': 'Verdict on the file',
});
const fileInput = h('input', {
  type: 'file',
  id: 'file',
  hidden: true,
  'aria-label': 'Mesh, model, names or recording',
  accept: '.off,.obj,.stl,.ply,.gltf,.glb,.dae,.3mf,.fbx,.sqmap,.json,.csv',
  multiple: true,
  onchange: () => {
    drop([...(fileInput.files ?? [])]);
    fileInput.value = '';
  },
});

const exportsRow = h('div', { class: 'row wrap', id: 'exports' });
export const openButton = h('button', { id: 'open', onclick: () => fileInput.click() }, 'Open …');
const widthChoice = h(
  'select',
  { id: 'picture-width', 'aria-label': 'Width of the picture' },
  ...[
    ['0', 'as on the screen'],
    ['1920', '1920 wide'],
    ['3840', '3840 wide'],
    ['7680', '7680 wide'],
  ].map(([v, t]) => h('option', { value: v }, t)),
);
const figureButton = h(
  'button',
  {
    id: 'save-figure',
    onclick: async () => {
      const glb = await costume.glb();
      if (glb) save('figure.glb', glb, 'model/gltf-binary');
      else trouble('The figure is not there yet.');
    },
  },
  'Dressed figure as GLB',
);
/// The menu of exports.
export const exportMenu = h(
  'details',
  { class: 'menu', id: 'export' },
  h('summary', { class: 'button' }, 'Export'),
  h(
    'div',
    { class: 'menu-body card' },
    fileInput,
    exportsRow,
    h(
      'div',
      { class: 'row wrap' },
      h(
        'button',
        {
          id: 'picture',
          onclick: async () => {
            const b = await world.picture(Number(widthChoice.value));
            if (b) save('sqmap.png', b, 'image/png');
            else trouble('There is no picture: this browser has no WebGL.');
          },
        },
        'Picture',
      ),
      widthChoice,
    ),
    h(
      'div',
      { class: 'row wrap' },
      h('button', { id: 'link', onclick: () => copyLink() }, 'Copy link to this view'),
      pageButton,
      figureButton,
    ),
  ),
);
document.addEventListener('pointerdown', (e) => {
  if (exportMenu.open && !exportMenu.contains(e.target as Node)) exportMenu.open = false;
});
exportMenu.addEventListener('keydown', (e) => {
  if (e.key === 'Escape') {
    exportMenu.open = false;
    exportMenu.querySelector('summary')!.focus();
  }
});

/// The files that the program writes for an object: address, ending, words of the button.
const EXPORTS: [string, string, string][] = [
  ['glb', 'glb', 'GLB'],
  ['json', 'json', 'JSON'],
  ['sqmap', 'sqmap', 'Model'],
  ['names', 'names.json', 'Names'],
];
async function saveExport(object: number, what: string, ending: string): Promise<void> {
  const { name, edited } = state.facts[object];
  if (what === 'sqmap' && edited) {
    trouble('Bake the edited parts first: the model file would hold the parts of before.');
    return;
  }
  try {
    save(`${name}.${ending}`, await fetchBytes(`/api/object/${object}/${what}`), 'application/octet-stream');
  } catch (e) {
    trouble(e);
  }
}

function showExports(): void {
  const i = state.selected?.object ?? 0,
    f = state.facts[i];
  figureButton.hidden = state.mode !== 'dress';
  exportsRow.hidden = state.mode === 'dress';
  exportsRow.replaceChildren(
    ...(f && !saved
      ? [
          h('span', { class: 'note' }, `Save ${f.name} as`),
          ...EXPORTS.map(([what, ending, words]) =>
            h('button', { id: `save-${what}`, onclick: () => void saveExport(i, what, ending) }, words),
          ),
        ]
      : []),
  );
}

on(['scene', 'selected', 'mode'], showExports);
let checkedIn = state.mode;
on(['mode'], () => {
  if (state.mode !== checkedIn) dialog.hidden = true;
  checkedIn = state.mode;
});

// ---- Files that are opened, one after the other

/// A file in the queue. number: no other file of this program has it; replaces: the number of an earlier reading of the file, or 0.
interface Waiting {
  file: File;
  number: number;
  replaces: number;
  row: HTMLLIElement;
  said: HTMLElement;
  abort: AbortController;
  repair: string;
}
const queue: Waiting[] = [];
let busy = false;

const repairChoice = choice(
  'Repair',
  [
    ['', 'whatever it needs'],
    ['close', 'close holes, no wrapping'],
    ['safe', 'only what moves nothing'],
    ['none', 'nothing'],
    ['surface', 'take it as a surface'],
  ],
  '',
  () => {},
  'repair',
);
const unitChoice = choice(
  'Unit of the file',
  [
    ['', 'as it says, or its own'],
    ['1', 'metre'],
    ['0.01', 'centimetre'],
    ['0.001', 'millimetre'],
    ['0.0254', 'inch'],
  ],
  '',
  () => {},
  'unit',
);
const projectionChoice = choice(
  'It gets',
  [
    ['central', 'Central maps'],
    ['normal', 'The paper’s maps'],
  ],
  'central',
  () => {},
  'projection',
);
const numberInput = (id: string, hint: string, label: string) =>
  h('input', { type: 'number', id, step: 'any', placeholder: hint, 'aria-label': label });
const thicknessInput = numberInput('thickness', '0: no sheets', 'Thickness of sheets, units of the file');
const errorInput = numberInput('target-error', '0.5', 'Depth error of layer 3 at most, percent of R max');
const partsInput = numberInput('max-parts', '24', 'Parts at most');
const valueOf = (field: HTMLElement): string => field.querySelector('select')!.value;
const queueList = h('ul', { class: 'queue', id: 'queue' });
const verdictBox = h('div', {});
const againButton = h(
  'button',
  {
    id: 'read-again',
    hidden: true,
    onclick: () => {
      if (newest) readAgain(newest, '');
    },
  },
  '',
);
const optionsBox = folded(
  'How a file is read',
  'file-options',
  repairChoice,
  h('label', { class: 'field' }, h('span', {}, 'Sheets are'), thicknessInput),
  unitChoice,
  projectionChoice,
  h('label', { class: 'field' }, h('span', {}, 'Depth error at most'), errorInput),
  h('label', { class: 'field' }, h('span', {}, 'Parts at most'), partsInput),
  h(
    'p',
    { class: 'note' },
    'Sheets: open surfaces become plates of this thickness, in units of the file. Depth error: of layer 3, percent of R_max.',
  ),
  againButton,
);
dialog.addEventListener('keydown', (e) => {
  if (e.key === 'Escape') {
    dialog.hidden = true;
    readingButton.focus();
  }
});
fill(
  dialog,
  queueList,
  verdictBox,
  optionsBox,
  h('p', { class: 'note' }, 'A file may have 64 MB and 500,000 faces, the scene 16 objects; sqmap bake has no such limits.'),
  h(
    'div',
    { class: 'row wrap' },
    h(
      'button',
      {
        id: 'close-verdict',
        onclick: () => {
          dialog.hidden = true;
          readingButton.focus();
        },
      },
      'Close',
    ),
  ),
);

/// The choices, before any file is opened.
export const readingButton = h(
  'button',
  {
    id: 'reading',
    'aria-label': 'How files are read',
    title: 'How files are read',
    onclick: () => {
      dialog.hidden = false;
      optionsBox.open = true;
      openSheet(true);
      dialog.scrollIntoView();
      repairChoice.querySelector('select')!.focus();
    },
  },
  '▾',
);

let newest: Waiting | null = null; ///< the mesh whose verdict is shown
function say(one: Waiting, text: string, over = false): void {
  one.said.textContent = text;
  if (over) one.row.querySelector('button')!.hidden = true;
}
const rows = new Map<number, Waiting>(); ///< the files that are being baked, by number

/// Cancels a file that is being sent, waits in the program or is being baked.
function cancel(one: Waiting): void {
  one.abort.abort();
  link.say({ say: 'cancel', upload: one.number });
  const held = one.row.contains(document.activeElement);
  say(one, 'cancelled', true);
  if (held) (queueList.querySelector<HTMLElement>('button:not([hidden])') ?? dialog).focus();
}
/// Reads a file again with the present choices. The earlier object goes once the file is accepted, and stays if it is refused.
function readAgain(one: Waiting, repair: string): void {
  if (rows.has(one.number)) cancel(one);
  drop([one.file], repair, state.facts.some((f) => f.upload === one.number) ? one.number : one.replaces);
}
function removeUpload(number: number): void {
  const at = number ? state.facts.findIndex((f) => f.upload === number) : -1;
  if (at >= 0) {
    select(-1, -1);
    link.say({ say: 'remove', object: at });
  }
}

/// Queues files. repair: replaces the choice for these files; replaces: as in Waiting.
function drop(files: Iterable<File>, repair = '', replaces = 0): void {
  for (const file of files) {
    const said = h('span', { class: 'note' }, 'waiting'),
      abort = new AbortController(),
      number = 1 + Math.floor(0xfffffffe * Math.random());
    const row = h(
      'li',
      {},
      h('span', { class: 'queue-name' }, file.name),
      said,
      h('button', { class: 'small', 'aria-label': `Cancel ${file.name}`, onclick: () => cancel(one) }, '✕'),
    );
    const one: Waiting = { file, number, replaces, row, said, abort, repair };
    queue.push(one);
    queueList.append(row);
  }
  while (queueList.childElementCount > 6) queueList.firstElementChild!.remove();
  void work();
}

async function work(): Promise<void> {
  if (busy) return;
  busy = true;
  for (let next = queue.shift(); next; next = queue.shift()) if (!next.abort.signal.aborted) await check(next);
  busy = false;
}

async function check(one: Waiting): Promise<void> {
  const { file, abort } = one;
  dialog.hidden = false;
  dialog.className = 'card verdict';
  verdictBox.replaceChildren();
  openSheet(true);
  try {
    const options = {
      repair: one.repair || valueOf(repairChoice),
      thickness: thicknessInput.value,
      unit: valueOf(unitChoice),
      projection: valueOf(projectionChoice),
      target_error: errorInput.value,
      max_parts: partsInput.value,
      upload: String(one.number),
    };
    const sent = (share: number) => {
        if (!abort.signal.aborted) say(one, share < 1 ? `sending ${Math.round(100 * share)} %` : 'checking …');
      },
      records = /\.csv$/i.test(file.name);
    rows.set(one.number, one);
    const v = await (records ? openRecording(file, sent, abort.signal) : upload(file, options, sent, abort.signal));
    if (records && v.accepted) setMode('touch');
    if (v.accepted) removeUpload(one.replaces);
    const good = v.accepted,
      baked = !good || v.triangles === undefined;
    if (baked) {
      rows.delete(one.number);
      say(one, good ? '✓' : '✗', true);
    } else if (rows.has(one.number) && !one.said.textContent!.startsWith('baking')) say(one, 'waiting to be baked'); // a small mesh's progress can come before its verdict
    dialog.className = `card verdict ${good ? 'good' : 'bad'}`;
    const mesh = !records && !/\.(sqmap|names\.json)$/.test(file.name);
    newest = mesh ? one : null;
    againButton.hidden = !mesh;
    againButton.textContent = `Read ${file.name} again`;
    fill(
      verdictBox,
      h('h2', {}, file.name),
      h('p', { class: 'word' }, `${good ? '✓' : '✗'} ${decision(v)}`),
      v.message && h('p', {}, `${v.element ? `At ${v.element}: ` : ''}${v.message}`),
      v.cure && h('p', {}, `What helps: ${v.cure}`),
      v.notes?.length ? h('ul', {}, ...v.notes.map((n) => h('li', {}, n))) : null,
      (v.code === 'E_OPEN' || v.code === 'E_FLAT' || v.verdict === 'CLOSED' || v.verdict === 'WRAPPED') &&
        options.repair !== 'surface' &&
        h('button', { id: 'as-surface', onclick: () => readAgain(one, 'surface') }, 'Take it as a surface without inside'),
    );
    if (!good && mesh) optionsBox.open = true;
    announce(`${file.name}: ${decision(v)}. ${v.message ?? ''}`, !good);
    if (!good) dialog.focus();
  } catch (e) {
    rows.delete(one.number);
    say(one, abort.signal.aborted ? 'cancelled' : '✗', true);
    if (!abort.signal.aborted) trouble(new Error(`${file.name}: ${e instanceof Error ? e.message : e}`));
  }
}

/// Shows the progress of a bake in the queue.
export function heardProgress({ upload: number, stage }: Progress): void {
  const one = rows.get(number),
    ends: Record<string, string> = { done: '✓', failed: '✗', cancelled: 'cancelled' };
  if (!one || one.abort.signal.aborted) {
    if (stage in ends) rows.delete(number);
    return;
  }
  say(one, ends[stage] ?? 'baking …', stage in ends);
  if (stage in ends) rows.delete(number);
}
/// The words over the page while a file is dragged across it.
export const zone = h(
  'div',
  { class: 'dropzone', id: 'dropzone', hidden: true },
  h('strong', {}, 'Drop meshes: they are checked, then baked. Or a model, names, a recording'),
);
addEventListener('dragover', (e) => {
  e.preventDefault();
  zone.hidden = false;
});
addEventListener('dragleave', (e) => {
  if (!e.relatedTarget) zone.hidden = true;
});
addEventListener('drop', (e) => {
  e.preventDefault();
  zone.hidden = true;
  drop([...(e.dataTransfer?.files ?? [])]);
});

showExports();
