// What a reload keeps and Back goes back to: tab, view, selection.
import { setMode, tabs } from './modes';
import { restoreLink } from './panels/files';
import { lookPanel } from './panels/look';
import { select } from './panels/parts';
import { world } from './stage';
import { MODES, on, state, type Mode } from './state';

const KEY = 'sqmap view';

interface Kept { colour: string; mode: Mode; pose: number[]; selected: { object: number; part: number } | null; objects: number[]; }

addEventListener('pagehide', () => {
  const kept: Kept = { colour: world.objects.colourBy, mode: state.mode, pose: world.pose(), selected: state.selected, objects: state.facts.map((f) => f.id) };
  try { sessionStorage.setItem(KEY, JSON.stringify(kept)); } catch { /* a browser that keeps nothing */ }
});

/// Of a link, else of before the reload.
export function restoreView(): void {
  if (restoreLink()) return;
  try {
    const kept = JSON.parse(sessionStorage.getItem(KEY) ?? 'null') as Kept | null;
    if (!kept || !MODES.includes(kept.mode) || String(kept.objects) !== String(state.facts.map((f) => f.id))) return;
    if (!tabs[kept.mode].hidden) setMode(kept.mode);
    if (kept.mode !== 'dress') world.setPose(kept.pose);
    const colour = lookPanel.querySelector<HTMLSelectElement>('#colour')!;
    if (kept.colour !== colour.value && [...colour.options].some((o) => o.value === kept.colour && !o.disabled)) { colour.value = kept.colour; colour.dispatchEvent(new Event('change')); }
    if (kept.selected && state.facts[kept.selected.object]) select(kept.selected.object, kept.selected.part);
  } catch { /* what somebody else wrote there */ }
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
