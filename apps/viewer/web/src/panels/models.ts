// The facts of the open models, in a line that stays in sight and in the list.
import { bytes, digits } from '../dom';
import type { ObjectFacts } from '../messages';
import { factsLine, world } from '../stage';
import { on, state } from '../state';

export const count = (n: number): string => (n === 1 ? '1 part' : `${n} parts`);

/// A length as a percentage of R_max; a share that is nothing but rounding reads 0.
function share(f: ObjectFacts, length: number): string {
  const percent = (100 * length * f.metresPerUnit) / f.rMax;
  return `${percent < 1e-4 ? '0' : digits(percent, 2)} %`;
}
/// The cure of the file's surface in words, with the distance by which it moved, the larger of both directions.
export function cureWords(f: ObjectFacts): string {
  const c = f.cure!,
    greater = (k: string) => share(f, Math.max(c.result_to_input[k], c.input_to_result[k]));
  return `${c.rung}: ${digits(100 * c.made_up_share, 2)} % of the surface is made up; the rest moved by at most ${greater('max')} of its size, 99 % of it by ${greater('p99')}`;
}
export function cureDetails(f: ObjectFacts): string {
  const c = f.cure!,
    way = (d: Record<string, number>) => `mean ${share(f, d.mean)}, p99 ${share(f, d.p99)}, max ${share(f, d.max)} of its size`;
  return `From the file to the mesh: ${way(c.input_to_result)}. From the mesh to the file: ${way(c.result_to_input)}.`;
}

/// The object that the line is about, of those that are shown: in Touch the one that was touched since something was selected, else the
/// selected, the one that is drawn large, or the only one.
function subject(): ObjectFacts | undefined {
  if (state.playing) return undefined;
  const shown = state.facts.filter((f) => !f.hidden),
    of = [state.mode === 'touch' ? state.touched : -1, state.selected?.object ?? -1, world.objects.focus].map(
      (i) => state.facts[i],
    );
  return of.find((f) => f && !f.hidden) ?? (shown.length === 1 ? shown[0] : undefined);
}
/// Points that layer 3 decided wrongly when the bake measured it: those nearer to the surface than 0.5 % of the size do not count.
function wrong(all: ObjectFacts[]): string {
  const sum = (of: (g: ObjectFacts) => number) => all.reduce((n, g) => n + of(g), 0),
    missed = sum((g) => g.measured.missed),
    made = sum((g) => g.measured.false);
  if (missed + made === 0) return '';
  const held = all.every((g) => g.exact || g.measured.missed + g.measured.false === 0);
  return `, layer 3 missed ${missed} and made up ${made} of ${sum((g) => g.measured.points).toLocaleString('en')} points${held ? ', which touch by exact triangles holds' : ''}`;
}
/// Layer and force that answer the touch of these objects.
function answering(all: ObjectFacts[]): string {
  const { layer, paperForce, tool } = state.settings,
    by =
      layer === 'tool'
        ? tool === 'ball' && !paperForce && all.every((f) => f.exact)
          ? 'exact triangles'
          : 'layer 3'
        : layer === 'exact'
          ? 'exact triangles'
          : layer === 'auto' || layer === 'gate'
            ? `layer by ${layer}`
            : `layer ${layer}`;
  return ` · touched by ${by}${paperForce ? ' and the paper’s force' : ''}`;
}
/// Shows the facts of one object, else of all.
function showFactsLine(): void {
  factsLine.hidden = state.mode === 'dress' || state.facts.every((f) => f.hidden);
  if (factsLine.hidden) return;
  const f = subject();
  const all = f ? [f] : state.facts.filter((g) => !g.hidden),
    certified = all.every((g) => g.parts.every((p) => p.certified));
  const total = count(all.reduce((n, g) => n + g.parts.length, 0)),
    most = (of: string) => digits(Math.max(...all.map((g) => g.measured[of])), 2);
  factsLine.textContent = all.some((g) => g.edited)
    ? `${f ? `${f.name}: ` : `${all.length} models: `}${total}, edited: bake them to know bytes and errors`
    : `${f ? `${f.name}: ` : `${all.length} models: `}${total} · ${bytes(all.reduce((n, g) => n + g.bytes.total, 0))} · ${certified ? '✓ certified to hold the surface' : '✗ not all certified'} · 99 % of depths measured within ${most('depthP99')} % of ${all.length > 1 ? 'their' : 'its'} size, the worst of ${all.reduce((n, g) => n + g.measured.points, 0).toLocaleString('en')} points off by ${most('depthMax')} %${all.every((g) => g.hasTriangles) ? '' : ' · without triangles: superquadrics are drawn'}${wrong(all)}${state.mode === 'touch' ? answering(all) : ''}`;
}

on(['scene', 'selected', 'playing', 'touched', 'status', 'mode', 'focus'], showFactsLine);
