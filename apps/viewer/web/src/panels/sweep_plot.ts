// The plot, the table and the sentence of a sweep of the press: force against depth.
import { digits, stepOf, svg } from '../dom';

const WIDE = 300,
  HIGH = 190,
  LEFT = 38,
  RIGHT = 8,
  TOP = 10,
  BOTTOM = 34; // px

/// press, depth: m below the surface that the hand wants, and where the tool came to rest. force, spread: mean and standard deviation
/// over the last ticks, N. torque: N m. limited: the force limit was at work. still: it had come to rest.
export interface Row {
  press: number;
  depth: number;
  force: number;
  spread: number;
  torque: number;
  limited: boolean;
  still: boolean;
}
export interface Swept {
  object: string;
  part: string;
  stiffness: number;
  limit: number;
  layer: string;
  rows: Row[];
}

/// The stiffness that the depths below the limit show, N/m: the line through no force at no depth that fits them best.
export function slopeOf(rows: Row[]): number | null {
  const free = rows.filter((r) => !r.limited && r.depth > 1e-5);
  return free.length < 2
    ? null
    : free.reduce((sum, r) => sum + r.force * r.depth, 0) / free.reduce((sum, r) => sum + r.depth * r.depth, 0);
}

/// The last sweep that has a depth.
const newestOf = (all: Swept[]): Swept => [...all].reverse().find((s) => s.rows.length > 0)!;

interface Ink {
  ink: string;
  soft: string;
  grid: string;
  line: string;
  second: string;
  paper: string;
}
const PRINT: Ink = { ink: '#111111', soft: '#555555', grid: '#cccccc', line: '#0b5cad', second: '#b3541e', paper: '#ffffff' };
function inkNow(): Ink {
  const style = getComputedStyle(document.documentElement),
    colour = (name: string) => style.getPropertyValue(name).trim();
  return {
    ink: colour('--ink'),
    soft: colour('--soft'),
    grid: colour('--line'),
    line: colour('--accent'),
    second: colour('--second'),
    paper: colour('--card'),
  };
}
/// The plot on the page, hidden while there is nothing to draw.
export class SweepPlot {
  readonly element = svg('svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, class: 'sweep-plot', id: 'sweep-plot', role: 'img' });
  show(all: Swept[]): void {
    const some = all.some((s) => s.rows.length > 0);
    this.element.toggleAttribute('hidden', !some);
    this.element.replaceChildren(...(some ? picture(all, inkNow()) : []));
    if (some) this.element.setAttribute('aria-label', `Force against depth. ${summary(newestOf(all))}`);
  }
}

/// A sweep in a sentence.
export function summary(s: Swept): string {
  const slope = slopeOf(s.rows),
    limited = s.rows.find((r) => r.limited),
    top = s.rows[s.rows.length - 1];
  return `${s.object}: ${s.rows.length} depths, ${top.force.toFixed(2)} N at ${(1000 * top.depth).toFixed(1)} mm${slope === null ? '' : `; ${digits(slope)} N/m below the limit`}${limited ? `; at the force limit from ${(1000 * limited.depth).toFixed(1)} mm on` : ''}.`;
}

/// Axes, then the sweeps: the newest in full colour with the line that its settings promise.
function picture(all: Swept[], c: Ink): SVGElement[] {
  const rows = all.flatMap((s) => s.rows),
    newest = newestOf(all),
    out: SVGElement[] = [];
  const far = 1000 * Math.max(...rows.map((r) => r.depth), 0.001) * 1.05,
    high = Math.max(...rows.map((r) => r.force), 0.1) * 1.15,
    wide = WIDE - LEFT - RIGHT,
    tall = HIGH - TOP - BOTTOM;
  const x = (mm: number) => (LEFT + (wide * mm) / far).toFixed(1),
    y = (n: number) => (TOP + tall * (1 - n / high)).toFixed(1);
  for (let k = 0, step = stepOf(high, 5); k * step <= high; ++k) {
    out.push(
      svg('line', { x1: LEFT, x2: WIDE - RIGHT, y1: y(k * step), y2: y(k * step), stroke: c.grid }),
      svg(
        'text',
        { x: LEFT - 5, y: Number(y(k * step)) + 4, 'text-anchor': 'end', fill: c.soft, 'font-size': 11 },
        String(Number((k * step).toPrecision(4))),
      ),
    );
  }
  for (let k = 0, step = stepOf(far, 5); k * step <= far; ++k)
    out.push(
      svg('line', { x1: x(k * step), x2: x(k * step), y1: TOP, y2: TOP + tall, stroke: c.grid }),
      svg(
        'text',
        { x: x(k * step), y: TOP + tall + 14, 'text-anchor': 'middle', fill: c.soft, 'font-size': 11 },
        String(Number((k * step).toPrecision(4))),
      ),
    );
  out.push(
    svg(
      'text',
      { x: LEFT + wide / 2, y: HIGH - 5, 'text-anchor': 'middle', fill: c.ink, 'font-size': 11.5 },
      'depth of the tool, mm',
    ),
    svg(
      'text',
      {
        x: 0,
        y: 0,
        transform: `translate(10 ${TOP + tall / 2}) rotate(-90)`,
        'text-anchor': 'middle',
        fill: c.ink,
        'font-size': 11.5,
      },
      'force, N',
    ),
  );
  // The spring that is set, up to the limit that is set.
  const knee = Math.min((1000 * newest.limit) / newest.stiffness, far),
    end = newest.stiffness * knee * 1e-3;
  out.push(
    svg('polyline', {
      points: `${x(0)},${y(0)} ${x(knee)},${y(Math.min(end, high))} ${x(far)},${y(Math.min(end, high))}`,
      fill: 'none',
      stroke: c.soft,
      'stroke-dasharray': '4 3',
    }),
  );
  for (const s of all) {
    const colour = s === newest ? c.line : c.soft,
      faint = s === newest ? 1 : 0.5;
    out.push(
      svg('polyline', {
        points: s.rows.map((r) => `${x(1000 * r.depth)},${y(r.force)}`).join(' '),
        fill: 'none',
        stroke: colour,
        opacity: faint,
        'stroke-width': 1.5,
      }),
      ...s.rows.map((r) =>
        svg('circle', {
          cx: x(1000 * r.depth),
          cy: y(r.force),
          r: 3,
          fill: r.limited ? c.paper : colour,
          stroke: r.limited ? c.second : colour,
          'stroke-width': 1.5,
          opacity: faint,
        }),
      ),
    );
  }
  return out;
}

/// One row a depth, of all sweeps that are kept.
export function csv(kept: Swept[]): string {
  const cell = (s: string) => {
    const t = /^[=+\-@]/.test(s) ? `'${s}` : s;
    return /[",\n]/.test(t) ? `"${t.replaceAll('"', '""')}"` : t;
  };
  const head =
    'sweep,object,part,layer,stiffness_N_per_m,force_limit_N,press_mm,depth_mm,force_N,force_sd_N,torque_mNm,at_limit,still';
  return (
    [
      head,
      ...kept.flatMap((s, i) =>
        s.rows.map((r) =>
          [
            i + 1,
            cell(s.object),
            cell(s.part),
            s.layer,
            digits(s.stiffness, 6),
            digits(s.limit, 6),
            (1000 * r.press).toFixed(1),
            (1000 * r.depth).toFixed(4),
            r.force.toFixed(5),
            r.spread.toFixed(5),
            (1000 * r.torque).toFixed(4),
            Number(r.limited),
            Number(r.still),
          ].join(','),
        ),
      ),
    ].join('\n') + '\n'
  );
}

/// The plot for a paper: black on white, with its facts below.
export function drawing(kept: Swept[]): string {
  const s = kept[kept.length - 1],
    high = HIGH + 18;
  const all = svg('svg', {
    viewBox: `0 0 ${WIDE} ${high}`,
    width: 2 * WIDE,
    height: 2 * high,
    'font-family': 'system-ui, sans-serif',
  });
  all.append(
    svg('rect', { width: WIDE, height: high, fill: PRINT.paper }),
    ...picture(kept, PRINT),
    svg(
      'text',
      { x: LEFT, y: HIGH + 10, fill: PRINT.soft, 'font-size': 9 },
      `${s.object}${s.part ? `, ${s.part}` : ''}: ${digits(s.stiffness)} N/m, limit ${digits(s.limit)} N. Dashed: that spring. Hollow: at the limit.`,
    ),
  );
  return `${new XMLSerializer().serializeToString(all)}\n`;
}
