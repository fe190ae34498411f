// Meshes and models that are opened, saved, and linked to.
import { announce, fill, h, save } from '../dom';
import { setMode, tabs } from '../modes';
import { address, upload, type Settings } from '../net';
import { trouble, wait } from '../notices';
import { world } from '../stage';
import { MODES, on, state, type Mode } from '../state';
import { setTheme, THEMES } from '../theme';
import { card, choice } from './controls';
import { costume } from './dress';
import { lookPanel } from './look';
import { select } from './parts';
import { tellSettings } from './touch';

/// What was found in a file.
export const dialog = h('section', { class: 'card verdict', id: 'verdict', hidden: true, tabIndex: -1, 'aria-label': 'Verdict on the file' });
const fileInput = h('input', { type: 'file', id: 'file', class: 'sr-only', accept: '.off,.obj,.stl,.ply,.gltf,.glb,.sqmap,.json', onchange: () => { const f = fileInput.files?.[0]; if (f) void drop(f); fileInput.value = ''; } });

let projection = 'central';
const exportsRow = h('div', { class: 'row wrap', id: 'exports' });
export const sharePanel = card('Files', h('div', { class: 'row wrap' },
  h('button', { id: 'open', onclick: () => fileInput.click() }, 'Open a mesh …'), fileInput,
  h('button', { id: 'picture', onclick: async () => { const b = await world.picture(); if (b) save('sqmap.png', b, 'image/png'); } }, 'Picture'),
  h('button', { id: 'link', onclick: () => copyLink() }, 'Copy link')),
  choice('New meshes get', [['central', 'Central maps'], ['normal', 'The paper’s maps']], 'central', (v) => { projection = v; }, 'projection'),
  exportsRow);

function showExports(): void {
  const i = state.selected?.object ?? 0, f = state.facts[i];
  exportsRow.replaceChildren(...(f ? [
    h('span', { class: 'note' }, `Save ${f.name} as`),
    ...(['glb', 'json', 'sqmap'] as const).map((kind) => kind === 'sqmap' && f.edited ? h('button', { id: 'save-sqmap', onclick: () => trouble('Bake the edited parts first: the model file would hold the parts of before.') }, 'Model') : h('a', { class: 'button', id: `save-${kind}`, href: address(`/api/object/${i}/${kind}`), download: `${f.name}.${kind}` }, kind === 'glb' ? 'GLB' : kind === 'json' ? 'JSON' : 'Model')),
    h('a', { class: 'button', id: 'save-names', href: address(`/api/object/${i}/names`), download: `${f.name}.names.json` }, 'Names')] : []));
}

on(['scene', 'selected'], showExports);
let checkedIn = state.mode;
on(['mode'], () => { if (state.mode !== checkedIn) dialog.hidden = true; checkedIn = state.mode; });

async function drop(file: File, repair: '' | 'surface' = ''): Promise<void> {
  dialog.hidden = false;
  dialog.className = 'card verdict';
  dialog.replaceChildren(h('h2', {}, file.name), h('p', {}, 'Checking …'));
  try {
    const v = await upload(file, repair, projection, (share) => { dialog.lastElementChild!.textContent = share < 1 ? `Sending ${Math.round(100 * share)} %` : 'Checking …'; });
    const good = v.accepted;
    dialog.className = `card verdict ${good ? 'good' : 'bad'}`;
    fill(dialog, h('h2', {}, file.name), h('p', { class: 'word' }, `${good ? '✓' : '✗'} ${v.verdict}${v.code ? ` ${v.code}` : ''}`),
      v.message && h('p', {}, `${v.element ? `At ${v.element}: ` : ''}${v.message}`), v.cure && h('p', {}, `What helps: ${v.cure}`),
      v.notes?.length ? h('ul', {}, ...v.notes.map((n) => h('li', {}, n))) : null,
      (v.code === 'E_OPEN' || v.code === 'E_FLAT' || v.verdict === 'CLOSED' || v.verdict === 'WRAPPED') && repair !== 'surface' && h('button', { id: 'as-surface', onclick: () => void drop(file, 'surface') }, 'Take it as a surface without inside'), ' ',
      h('button', { onclick: () => { dialog.hidden = true; } }, 'Close'));
    announce(`${file.name}: ${v.verdict}. ${v.message ?? ''}`, !good);
    if (!good) dialog.focus();
  } catch (e) { dialog.hidden = true; trouble(`${file.name}: ${e instanceof Error ? e.message : e}`); }
}
/// Over the page while a file is dragged across it.
export const zone = h('div', { class: 'dropzone', id: 'dropzone', hidden: true }, h('strong', {}, 'Drop the mesh: it is checked, then baked'));
addEventListener('dragover', (e) => { e.preventDefault(); zone.hidden = false; });
addEventListener('dragleave', (e) => { if (!e.relatedTarget) zone.hidden = true; });
addEventListener('drop', (e) => { e.preventDefault(); zone.hidden = true; const f = e.dataTransfer?.files[0]; if (f) void drop(f); });

const OVERLAYS = ['spheres', 'samples', 'offset', 'hidden'];
function copyLink(): void {
  const view = { m: state.mode, c: world.pose(), k: world.objects.colourBy, s: world.objects.surfaceAs, q: world.objects.withSuperquadrics, o: OVERLAYS.filter((id) => lookPanel.querySelector<HTMLInputElement>(`#${id}`)!.checked), t: document.documentElement.dataset.theme, p: state.selected,
    f: state.mode === 'touch' ? state.settings : undefined, w: state.mode === 'dress' ? costume.chosen() : undefined };
  location.hash = `view=${encodeURIComponent(JSON.stringify(view))}`;
  const done = () => announce('The link is in the address bar and the clipboard. It holds as long as the program runs.');
  navigator.clipboard?.writeText(location.href).then(done, done);
  wait('Link copied: it restores this view as long as the program runs.');
}
export function restoreLink(): void {
  const text = new URLSearchParams(location.hash.slice(1)).get('view');
  if (!text) return;
  try {
    const v = JSON.parse(text);
    const set = (id: string, value: unknown) => { const e = lookPanel.querySelector<HTMLSelectElement & HTMLInputElement>(`#${id}`)!; if (typeof value === 'boolean') e.checked = value; else e.value = String(value); e.dispatchEvent(new Event('change')); };
    set('colour', v.k); set('surface', v.s); set('superquadrics', Boolean(v.q));
    for (const id of OVERLAYS) set(id, Array.isArray(v.o) && v.o.includes(id));
    if (THEMES.includes(v.t)) setTheme(v.t);
    if (v.f) {
      for (const k of Object.keys(state.settings) as (keyof Settings)[]) if (typeof v.f[k] === typeof state.settings[k] || k === 'tool') state.settings = { ...state.settings, [k]: v.f[k] };
      tellSettings();
    }
    if (Array.isArray(v.w)) costume.choose(v.w);
    if (MODES.includes(v.m) && !tabs[v.m as Mode].hidden) setMode(v.m as Mode);
    world.setPose(v.c);
    if (v.p && state.facts[v.p.object]) select(v.p.object, v.p.part);
  } catch { /* a link that somebody has changed: the view stays as it is */ }
}
showExports();
