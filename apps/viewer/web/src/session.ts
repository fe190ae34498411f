// Restores a view, from a link or after a reload, and the tab on Back.
import { announce } from './dom';
import type { Settings } from './messages';
import { setMode, tabs } from './modes';
import { program } from './net';
import { wait } from './notices';
import { costume } from './panels/dress';
import { lookPanel } from './panels/look';
import { select } from './panels/parts';
import { tellSettings } from './panels/settings';
import { world } from './stage';
import { MODES, on, state, type Mode } from './state';
import { setTheme, THEMES } from './theme';

const KEY = 'sqmap view',
  OVERLAYS = ['spheres', 'samples', 'offset', 'hidden'];
const control = (id: string) => lookPanel.querySelector<HTMLSelectElement & HTMLInputElement>(`#${id}`); // a saved page has not all
const ids = (): string => String(state.facts.map((f) => f.id));

/// Tab, camera, colours, surface, superquadrics, overlays, theme, selected part, settings of touch, costume.
export const viewNow = () => ({
  m: state.mode,
  c: world.pose(),
  k: world.objects.colourBy,
  s: world.objects.surfaceAs,
  q: world.objects.withSuperquadrics,
  o: OVERLAYS.filter((id) => control(id)?.checked),
  t: document.documentElement.dataset.theme,
  p: state.selected,
  l: world.objects.leftOut(),
  f: state.mode === 'touch' ? state.settings : undefined,
  w: state.mode === 'dress' ? costume.chosen() : undefined,
});

/// Shows a view, of which any member may be missing or wrong.
export function showView(v: Partial<Omit<ReturnType<typeof viewNow>, 'f'>> & { f?: Record<string, unknown> }): void {
  const set = (id: string, value: string | boolean | undefined) => {
    const e = control(id);
    if (!e || (typeof value !== 'boolean' && ![...e.options].some((o) => o.value === value && !o.disabled))) return;
    if (typeof value === 'boolean') e.checked = value;
    else e.value = value!;
    e.dispatchEvent(new Event('change'));
  };
  set('colour', v.k);
  set('surface', v.s);
  if (v.q !== undefined) set('superquadrics', Boolean(v.q));
  if (Array.isArray(v.o)) for (const id of OVERLAYS) set(id, v.o.includes(id));
  if (v.t && THEMES.includes(v.t)) setTheme(v.t);
  if (v.f) {
    for (const k of Object.keys(state.settings) as (keyof Settings)[])
      if (typeof v.f[k] === typeof state.settings[k] || k === 'tool') state.settings = { ...state.settings, [k]: v.f[k] };
    tellSettings();
  }
  if (Array.isArray(v.w)) costume.choose(v.w);
  if (v.m && MODES.includes(v.m) && !tabs[v.m].hidden) setMode(v.m);
  if (v.c) world.setPose(v.c);
  if (Array.isArray(v.l))
    for (const [object, part] of v.l) if (state.facts[object]?.parts[part]) world.objects.showPart(object, part, false);
  if (v.p && state.facts[v.p.object]) select(v.p.object, v.p.part);
}

export function copyLink(): void {
  location.hash = `view=${encodeURIComponent(JSON.stringify(viewNow()))}`;
  const holds = program.kind === 'worker' ? 'with the models that this page begins with' : 'as long as the program runs';
  const done = () => announce(`The link is in the address bar and the clipboard. It restores this view ${holds}.`);
  navigator.clipboard?.writeText(location.href).then(done, done);
  wait(`Link copied: it restores this view ${holds}.`);
}

addEventListener('pagehide', () => {
  const { m, c, k, p } = viewNow();
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ objects: ids(), view: { m, c: m === 'dress' ? undefined : c, k, p } }));
  } catch {
    /* a browser that keeps nothing */
  }
});

/// Restores the view of a link, else the view before a reload, if the objects are the same.
export function restoreView(): void {
  try {
    const link = new URLSearchParams(location.hash.slice(1)).get('view'),
      kept = JSON.parse(sessionStorage.getItem(KEY) ?? 'null');
    if (link) showView(JSON.parse(link));
    else if (kept?.objects === ids()) showView(kept.view);
  } catch {
    /* somebody has changed the link or the stored view: the view stays as it is */
  }
}

// Every tab is a step of the browser's history.
let back = false;
history.replaceState({ mode: state.mode }, '');
on(['mode'], () => {
  if (!back && history.state?.mode !== state.mode) history.pushState({ mode: state.mode }, '');
});
addEventListener('popstate', (e) => {
  const mode = (e.state as { mode?: Mode } | null)?.mode;
  if (!mode || !MODES.includes(mode)) return;
  back = true;
  setMode(mode);
  back = false;
});
