// The open models: a line that stays in sight, and a list.
import { bytes, digits, h } from '../dom';
import { lookAt } from '../first';
import type { ObjectFacts } from '../messages';
import { link, saved } from '../net';
import { question } from '../notices';
import { factsLine, world } from '../stage';
import { on, state } from '../state';
import { select } from './parts';

export const factsBox = h('div', { class: 'facts', id: 'facts' });
export const count = (n: number): string => (n === 1 ? '1 part' : `${n} parts`);

/// A length as a percentage of R_max; a share that is nothing but rounding reads 0.
function share(f: ObjectFacts, length: number): string {
  const percent = (100 * length * f.metresPerUnit) / f.rMax;
  return `${percent < 1e-4 ? '0' : digits(percent, 2)} %`;
}
/// The cure of the file's surface in words, with the distance by which it moved, the larger of both directions.
function cureWords(f: ObjectFacts): string {
  const c = f.cure!, greater = (k: string) => share(f, Math.max(c.result_to_input[k], c.input_to_result[k]));
  return `${c.rung}: ${digits(100 * c.made_up_share, 2)} % of the surface is made up; the rest moved by at most ${greater('max')} of its size, 99 % of it by ${greater('p99')}`;
}
function cureDetails(f: ObjectFacts): string {
  const c = f.cure!, way = (d: Record<string, number>) => `mean ${share(f, d.mean)}, p99 ${share(f, d.p99)}, max ${share(f, d.max)} of its size`;
  return `From the file to the mesh: ${way(c.input_to_result)}. From the mesh to the file: ${way(c.result_to_input)}.`;
}

/// The object that the line is about: in Touch the one that was touched last, else the selected or the only one.
function subject(): ObjectFacts | undefined {
  if (state.playing) return undefined;
  const touched = state.mode === 'touch' ? state.facts[state.touched] : undefined;
  return touched ?? state.facts[state.selected?.object ?? (state.facts.length === 1 ? 0 : -1)];
}
/// Points that layer 3 decided wrongly when the bake measured it.
function wrong(all: ObjectFacts[]): string {
  const n = all.reduce((sum, g) => sum + g.measured.missed + g.measured.false, 0);
  return n > 0 ? `, ${n} of ${all.reduce((sum, g) => sum + g.measured.points, 0).toLocaleString('en')} points wrong on layer 3` : '';
}
/// Layer and force that answer the touch.
function answering(): string {
  const { layer, paperForce } = state.settings, by = layer === 'tool' ? 'the tool’s own layer' : layer === 'exact' ? 'exact triangles' : layer === 'auto' || layer === 'gate' ? `layer by ${layer}` : `layer ${layer}`;
  return ` · touched by ${by}${paperForce ? ' and the paper’s force' : ''}`;
}
/// Shows the facts of one object, else of all.
function showFactsLine(): void {
  factsLine.hidden = state.mode === 'dress' || state.facts.length === 0;
  const f = subject();
  const all = f ? [f] : state.facts, certified = all.every((g) => g.parts.every((p) => p.certified));
  const total = count(all.reduce((n, g) => n + g.parts.length, 0)), worst = Math.max(...all.map((g) => g.measured.depthP99));
  factsLine.textContent = all.some((g) => g.edited) ? `${f ? `${f.name}: ` : `${all.length} models: `}${total}, edited: bake them to know bytes and errors` :
    `${f ? `${f.name}: ` : `${all.length} models: `}${total} · ${bytes(all.reduce((n, g) => n + g.bytes.total, 0))} · ${certified ? '✓ certified to hold the surface' : '✗ not all certified'} · 99 % of depths measured within ${digits(worst, 2)} % of ${all.length > 1 ? 'their' : 'its'} size${wrong(all)}${state.mode === 'touch' ? answering() : ''}`;
}

/// Hides the list in Recognise and Dress, which are not about models.
function hideFacts(): void { factsBox.hidden = state.mode === 'recognise' || state.mode === 'dress'; }

function showFacts(): void {
  showFactsLine();
  const rows = state.facts.map((f, i) => {
    const certified = f.parts.filter((p) => p.certified).length;
    const current = state.selected?.object === i;
    const title = h('button', { class: 'object', 'aria-pressed': String(current), onclick: () => { select(i, -1); lookAt(i); if (state.mode !== 'recognise') world.frame(i); } }, f.name + (f.edited ? ' (edited, not baked)' : ''));
    const warn = f.measured.missed + f.measured.false > 0;
    return h('li', {}, title,
      h('span', {}, `${count(f.parts.length)}, ${f.edited ? '' : `${bytes(f.bytes.total)}, `}${f.triangles.toLocaleString('en')} faces`),
      h('span', {}, `${f.central ? 'central maps' : 'the paper’s maps (normal)'}${f.exact ? ' and triangles' : ''}`),
      f.cure && h('span', { class: 'cure', title: cureDetails(f) }, cureWords(f)),
      h('span', { class: warn || certified < f.parts.length ? 'warn' : '', title: `Layer 3 on ${f.measured.points} points: ${f.measured.missed} missed, ${f.measured.false} false; depth error median ${digits(f.measured.depthMedian, 2)} %, 99th percentile ${digits(f.measured.depthP99, 2)} % of its size: R_max, the largest distance between two vertices` },
        f.edited ? 'Bytes, certificates and errors are told once the parts are baked.' : `${certified === f.parts.length ? '✓ all certified' : `✗ ${certified} certified`}; 99 % of depths within ${digits(f.measured.depthP99, 2)} %${warn ? `, ✗ ${f.measured.missed + f.measured.false} wrong` : ''}`));
  });
  factsBox.replaceChildren(h('section', { class: 'card' }, h('h2', {}, state.facts.length === 1 ? 'Model' : `Models (${state.facts.length})`),
    state.facts.length ? h('ul', { class: 'objects' }, ...rows) : h('p', {}, 'Nothing is open: drop a mesh, or press Open.'),
    state.facts.length > 1 && !saved && h('button', { id: 'remove-all', onclick: () => question(`Remove all ${state.facts.length} objects?`, 'Remove them', () => { select(-1, -1); for (let i = state.facts.length - 1; i >= 0; --i) link.say({ say: 'remove', object: i }); }) }, 'Remove all')));
  hideFacts();
}

on(['scene', 'selected', 'playing'], showFacts);
on(['touched', 'status'], showFactsLine);
on(['mode'], () => { showFactsLine(); hideFacts(); });
