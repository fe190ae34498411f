// A sweep of the press: twenty depths at one position, and force against depth as a plot that grows, kept as a table or a drawing.
import { announce, digits, h, save } from '../dom';
import { onFelt } from '../felt';
import type { Frame } from '../messages';
import { TICK } from '../net';
import { trouble } from '../notices';
import { hand } from '../stage';
import { on, state } from '../state';
import { onStop } from '../stop';
import { onTheme } from '../theme';

const COUNT = 20,
  STEP = 0.001; // depths; m from one to the next
const FRAMES = 12; // that have to be alike for a depth to count as still
const SAME = 0.003,
  FLAT = 2e-5; // by how much their force, N, and their depth, m, may differ
const GOES = 1e-4,
  LATEST = 8000; // m that the tool goes deeper before it can be still; ms to wait for that
const MOST_TRIES = 8; // times that a fault of a busy machine is lifted from
const LIMIT = 8 | 256; // bits of haptic::SafetyStep
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

const mean = (values: number[]): number => values.reduce((sum, x) => sum + x, 0) / Math.max(values.length, 1);
/// A value of the ticks of these frames: force 0, torque 1, depth 2.
const values = (frames: Frame[], which: number): number[] =>
  frames.flatMap((f) => Array.from({ length: f.ticks.length / TICK }, (_, i) => f.ticks[TICK * i + which]));

/// The stiffness that the depths below the limit show, N/m: the line through no force at no depth that fits them best.
export function slopeOf(rows: Row[]): number | null {
  const free = rows.filter((r) => !r.limited && r.depth > 1e-5);
  return free.length < 2
    ? null
    : free.reduce((sum, r) => sum + r.force * r.depth, 0) / free.reduce((sum, r) => sum + r.depth * r.depth, 0);
}

/// The last sweep that has a depth.
const newestOf = (all: Swept[]): Swept => [...all].reverse().find((s) => s.rows.length > 0)!;

const NS = 'http://www.w3.org/2000/svg';
function svg(tag: string, attributes: Record<string, string | number>, text = ''): SVGElement {
  const e = document.createElementNS(NS, tag);
  for (const [name, value] of Object.entries(attributes)) e.setAttribute(name, String(value));
  e.textContent = text;
  return e;
}
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
/// The step between two lines of an axis: 1, 2 or 5 times a power of ten.
function stepOf(top: number): number {
  const raw = top / 5,
    power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5, 10].find((k) => k * power >= raw) ?? 10);
}

class Sweep {
  readonly kept: Swept[] = []; ///< the newest is the last
  private now: Swept | null = null;
  private frames: Frame[] = [];
  private since = 0; ///< ms, of the newest change of depth
  private tries = 0;
  private lifted = 0; ///< ms, the time at which a fault was lifted from; 0: none
  private before = 0; ///< the press that the user had set
  private held = false; ///< the user held the tool
  private at: number[] = []; ///< the position that is pressed
  private canvas = svg('svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, class: 'sweep-plot', id: 'sweep-plot', role: 'img' });
  private words = h('p', { class: 'note', id: 'sweep-words', role: 'status' });
  private button = h('button', {
    id: 'sweep',
    title: 'Presses 1 to 20 mm deep where the tool touches, or touched last',
    onclick: () => {
      if (this.running) this.end('Ended.');
      else this.begin();
    },
  });
  private keep = [
    h('button', { id: 'sweep-table', onclick: () => save('force-depth.csv', this.csv(), 'text/csv') }, 'Table'),
    h('button', { id: 'sweep-drawing', onclick: () => save('force-depth.svg', this.drawing(), 'image/svg+xml') }, 'SVG'),
    h(
      'button',
      {
        id: 'sweep-clear',
        onclick: () => {
          this.kept.length = 0;
          this.show();
          this.button.focus();
        },
      },
      'Clear',
    ),
  ];
  readonly element = h(
    'div',
    { class: 'sweep' },
    h('div', { class: 'row wrap' }, this.button, ...this.keep),
    this.canvas as unknown as HTMLElement,
    this.words,
  );

  constructor() {
    onFelt((frame) => this.hear(frame));
    onStop(() => this.end('Stopped.'));
    onTheme(() => this.show());
    on(['mode', 'playing', 'scene'], () => {
      if (this.running && (state.mode !== 'touch' || state.playing)) this.end('Ended.');
      this.show();
    });
    this.show();
  }

  get running(): boolean {
    return this.now !== null;
  }

  begin(): void {
    const s = state.settings;
    this.now = {
      object: '',
      part: '',
      stiffness: s.stiffness,
      limit: state.status?.limit ?? s.forceLimit,
      layer: s.layer,
      rows: [],
    };
    this.tries = this.lifted = 0;
    this.at = [];
    this.before = hand.press;
    this.held = hand.holding;
    this.press();
    if (!this.held) hand.hold();
    this.show('Touching …');
  }

  /// The next depth.
  private press(): void {
    hand.press = STEP * (this.now!.rows.length + 1);
    hand.deeper(0);
    this.frames = [];
    this.since = performance.now();
  }

  private hear(frame: Frame): void {
    const now = this.now,
      time = performance.now();
    if (!now) return;
    if (this.lifted) {
      if (time - this.lifted < 400) return;
      this.lifted = 0;
      hand.hold();
      this.frames = [];
      this.since = time;
      return;
    }
    if (!hand.holding) {
      this.end('The tool was let go.');
      return;
    }
    if (frame.faults) {
      if (++this.tries > MOST_TRIES) {
        this.end('The computer is too busy for a steady force.');
        return;
      }
      hand.letGo();
      this.lifted = time;
      return;
    }
    if (!frame.engaged || frame.contacts === 0) {
      this.frames = [];
      if (time - this.since > LATEST)
        this.end(now.rows.length ? 'The tool has left the surface.' : 'Nothing is there: touch an object, then sweep.');
      return;
    }
    const place = hand.point;
    if (!this.at.length) this.at = place;
    else if (Math.hypot(...place.map((x, k) => x - this.at[k])) > 1e-5) {
      this.end('The hand has moved.');
      return;
    }
    this.frames.push(frame);
    if (this.frames.length > FRAMES) this.frames.shift();
    // Frames may be late: those of the depth before, which stood still as well, are told by their depth.
    const span = (of: (f: Frame) => number) => {
      const all = this.frames.map(of);
      return Math.max(...all) - Math.min(...all);
    };
    const went = frame.depth - (now.rows[now.rows.length - 1]?.depth ?? 0) > GOES;
    const still =
      went && this.frames.length === FRAMES && span((f) => Math.hypot(...f.force)) < SAME && span((f) => f.depth) < FLAT;
    if (!still && time - this.since < LATEST) return;
    this.take(still);
  }

  private take(still: boolean): void {
    const now = this.now!,
      last = this.frames[this.frames.length - 1],
      forces = values(this.frames, 0),
      force = mean(forces);
    now.object = state.facts[last.object]?.name ?? 'surface';
    now.part = state.facts[last.object]?.parts[last.part]?.name ?? '';
    now.rows.push({
      press: hand.press,
      depth: mean(values(this.frames, 2)),
      force,
      spread: Math.sqrt(mean(forces.map((x) => (x - force) ** 2))),
      torque: mean(values(this.frames, 1)),
      limited: this.frames.some((f) => (f.acted & LIMIT) !== 0),
      still,
    });
    if (now.rows.length === COUNT) {
      this.end('');
      return;
    }
    this.press();
    this.show(`${now.rows.length} of ${COUNT} depths: ${force.toFixed(2)} N`);
  }

  /// why: empty where all depths were reached.
  private end(why: string): void {
    const done = this.now;
    if (!done) return;
    this.now = null;
    if (done.rows.length) {
      this.kept.push(done);
      if (this.kept.length > 4) this.kept.shift();
    }
    if (!this.held || !hand.holding) hand.letGo();
    hand.press = this.before;
    hand.deeper(0);
    const text = done.rows.length ? `${why} ${this.summary(done)}`.trim() : why;
    this.show(text);
    if (done.rows.length) announce(text);
    else trouble(text);
  }

  private summary(s: Swept): string {
    const slope = slopeOf(s.rows),
      limited = s.rows.find((r) => r.limited),
      top = s.rows[s.rows.length - 1];
    return `${s.object}: ${s.rows.length} depths, ${top.force.toFixed(2)} N at ${(1000 * top.depth).toFixed(1)} mm${slope === null ? '' : `; ${digits(slope)} N/m below the limit`}${limited ? `; at the force limit from ${(1000 * limited.depth).toFixed(1)} mm on` : ''}.`;
  }

  private show(text?: string): void {
    const all = this.now ? [...this.kept, this.now] : this.kept,
      some = all.some((s) => s.rows.length > 0);
    this.button.textContent = this.running ? 'End the sweep' : 'Sweep 20 depths';
    this.button.disabled = state.playing || !state.facts.length;
    for (const b of this.keep) b.hidden = !this.kept.length || this.running;
    if (text !== undefined || !some) this.words.textContent = text ?? '';
    this.canvas.toggleAttribute('hidden', !some);
    if (!some) {
      this.canvas.replaceChildren();
      return;
    }
    this.canvas.replaceChildren(...this.picture(all, inkNow()));
    this.canvas.setAttribute('aria-label', `Force against depth. ${this.summary(newestOf(all))}`);
  }

  /// Axes, then the sweeps: the newest in full colour with the line that its settings promise.
  private picture(all: Swept[], c: Ink): SVGElement[] {
    const rows = all.flatMap((s) => s.rows),
      newest = newestOf(all),
      out: SVGElement[] = [];
    const far = 1000 * Math.max(...rows.map((r) => r.depth), 0.001) * 1.05,
      high = Math.max(...rows.map((r) => r.force), 0.1) * 1.15,
      wide = WIDE - LEFT - RIGHT,
      tall = HIGH - TOP - BOTTOM;
    const x = (mm: number) => (LEFT + (wide * mm) / far).toFixed(1),
      y = (n: number) => (TOP + tall * (1 - n / high)).toFixed(1);
    for (let k = 0, step = stepOf(high); k * step <= high; ++k) {
      out.push(
        svg('line', { x1: LEFT, x2: WIDE - RIGHT, y1: y(k * step), y2: y(k * step), stroke: c.grid }),
        svg(
          'text',
          { x: LEFT - 5, y: Number(y(k * step)) + 4, 'text-anchor': 'end', fill: c.soft, 'font-size': 11 },
          String(Number((k * step).toPrecision(4))),
        ),
      );
    }
    for (let k = 0, step = stepOf(far); k * step <= far; ++k)
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
  csv(): string {
    const cell = (s: string) => {
      const t = /^[=+\-@]/.test(s) ? `'${s}` : s;
      return /[",\n]/.test(t) ? `"${t.replaceAll('"', '""')}"` : t;
    };
    const head =
      'sweep,object,part,layer,stiffness_N_per_m,force_limit_N,press_mm,depth_mm,force_N,force_sd_N,torque_mNm,at_limit,still';
    return (
      [
        head,
        ...this.kept.flatMap((s, i) =>
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
  drawing(): string {
    const s = this.kept[this.kept.length - 1],
      high = HIGH + 18;
    const all = svg('svg', {
      viewBox: `0 0 ${WIDE} ${high}`,
      width: 2 * WIDE,
      height: 2 * high,
      'font-family': 'system-ui, sans-serif',
    });
    all.append(
      svg('rect', { width: WIDE, height: high, fill: PRINT.paper }),
      ...this.picture(this.kept, PRINT),
      svg(
        'text',
        { x: LEFT, y: HIGH + 10, fill: PRINT.soft, 'font-size': 9 },
        `${s.object}${s.part ? `, ${s.part}` : ''}: ${digits(s.stiffness)} N/m, limit ${digits(s.limit)} N. Dashed: that spring. Hollow: at the limit.`,
      ),
    );
    return `${new XMLSerializer().serializeToString(all)}\n`;
  }
}

export const sweep = new Sweep();
