// Strip charts of force, depth, torque and CPU time in the last seconds, with a value for each tick of the servo.
import { h, stepOf } from './dom';
import { meter } from './meter';
import type { Frame } from './messages';
import { TICK } from './net';

const SECONDS = 6,
  RATE = 1000,
  N = SECONDS * RATE;
const EVERY = 48; // ms between pictures
const LEFT = 34,
  RIGHT = 14,
  TOP = 9,
  BOTTOM = 20; // px about the curves
const FINEST = 2,
  GRID = 4; // pixels of the screen to one of the page, at most; lines across

/// The last N values of a quantity; the newest is at(N - 1).
class Trail {
  private values: Float32Array;
  private next = 0;
  constructor(private blank: number) {
    this.values = new Float32Array(N).fill(blank);
  }
  push(x: number): void {
    this.values[this.next] = x;
    this.next = (this.next + 1) % N;
  }
  at(i: number): number {
    return this.values[(this.next + i) % N];
  }
  clear(): void {
    this.values.fill(this.blank);
  }
}

interface Series {
  title: string;
  unit: string;
  pick: number;
  scale: number;
  least: number;
  of: number; ///< index among the values that are computed again; -1: this one is not
  values: Trail;
  again: Trail;
  top: number;
  box: HTMLElement;
  canvas: HTMLCanvasElement;
  cursor: HTMLElement;
  now: HTMLElement;
}
interface Style {
  ink: string;
  grid: string;
  line: string;
  second: string;
}

export class Charts {
  readonly element: HTMLElement;
  private series: Series[];
  private dirty = false;
  private drawn = 0;
  private wide = 0; ///< px, of each picture; 0: not in sight
  private high = 0;
  private style: Style = { ink: '', grid: '', line: '', second: '' };

  constructor() {
    const make = (title: string, unit: string, pick: number, scale: number, least: number, of = -1): Series => {
      const canvas = h('canvas', { 'aria-hidden': 'true' }),
        cursor = h('div', { class: 'cursor', hidden: true });
      return {
        title,
        unit,
        pick,
        scale,
        least,
        of,
        values: new Trail(0),
        again: new Trail(NaN),
        top: least,
        box: h('div', { class: 'chart-box' }, canvas, cursor),
        canvas,
        cursor,
        now: h('span', { class: 'chart-now' }, '0'),
      };
    };
    this.series = [
      make('Force', 'N', 0, 1, 2, 0),
      make('Depth', 'mm', 2, 1000, 2, 2),
      make('Torque', 'mN m', 1, 1000, 2, 1),
      make('CPU a tick', 'µs', 3, 1, 100),
    ];
    this.element = h(
      'section',
      { class: 'charts', 'aria-label': 'Strip charts of the last six seconds' },
      ...this.series.map((s) =>
        h(
          'figure',
          { class: 'chart' },
          h('figcaption', {}, h('span', {}, s.title), s.now, h('span', { class: 'unit' }, s.unit)),
          s.box,
        ),
      ),
    );
    new ResizeObserver(() => this.layout()).observe(this.element);
    this.element.addEventListener('pointermove', (e) => this.point(e, false));
    this.element.addEventListener('pointerdown', (e) => this.point(e, true));
    this.element.addEventListener('pointerleave', () => {
      for (const s of this.series) s.cursor.hidden = true;
    });
  }

  onPick: (secondsAgo: number) => void = () => {}; ///< the user chooses a moment of the charts

  /// Moves one cursor through all charts.
  private point(e: PointerEvent, picks: boolean): void {
    const over = this.series.find((s) => s.box.contains(e.target as Node))?.box.getBoundingClientRect();
    for (const s of this.series) s.cursor.hidden = !over;
    if (!over) return;
    const room = this.wide - LEFT - RIGHT,
      x = Math.min(Math.max(e.clientX - over.left - LEFT, 0), room);
    for (const s of this.series) s.cursor.style.transform = `translateX(${(LEFT + x).toFixed(1)}px)`;
    if (picks) this.onPick((1 - x / room) * SECONDS);
  }

  theme(): void {
    this.layout();
  }

  private layout(): void {
    this.wide = this.element.offsetParent ? Math.max(this.series[0].box.clientWidth, 60) : 0;
    this.high = Math.max(this.series[0].box.clientHeight, 40);
    const style = getComputedStyle(document.documentElement),
      colour = (name: string) => style.getPropertyValue(name).trim();
    this.style = { ink: colour('--soft'), grid: colour('--line'), line: colour('--accent'), second: colour('--second') };
    this.change();
  }

  onChange: () => void = () => {}; ///< there is something to draw
  /// Tells whether something waits to be drawn that is in sight.
  get wanting(): boolean {
    return this.dirty && this.wide > 0;
  }
  private change(): void {
    this.dirty = true;
    this.onChange();
  }

  /// Every animation frame; draws twenty times a second.
  frame(now: number): void {
    if (!this.dirty || now - this.drawn < EVERY || this.wide === 0) return;
    this.drawn = now;
    this.dirty = false;
    ++meter.chartDraws;
    for (const s of this.series) {
      s.now.textContent = (s.scale * s.values.at(N - 1)).toFixed(s.pick === 3 ? 0 : 2);
      this.draw(s);
    }
  }

  private draw(s: Series): void {
    const scale = Math.min(devicePixelRatio, FINEST),
      wide = Math.round(scale * this.wide),
      high = Math.round(scale * this.high);
    if (s.canvas.width !== wide || s.canvas.height !== high) {
      s.canvas.width = wide;
      s.canvas.height = high;
      s.canvas.style.width = `${this.wide}px`;
      s.canvas.style.height = `${this.high}px`;
    }
    const c = s.canvas.getContext('2d', { willReadFrequently: true })!,
      room = this.wide - LEFT - RIGHT,
      tall = this.high - TOP - BOTTOM; // drawn without the graphics card: it is little, and often
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, this.wide, this.high);
    const curve = this.curve(s.values, Math.max(Math.round(scale * room), 1)),
      again = s.of < 0 ? null : this.curve(s.again, Math.max(Math.round(scale * room), 1));
    s.top = Math.max(s.least, 1.15 * s.scale * Math.max(curve.most, again?.most ?? 0));
    c.font = '11px system-ui';
    c.fillStyle = this.style.ink;
    c.strokeStyle = this.style.grid;
    c.lineWidth = 1;
    const y = (v: number) => TOP + tall * (1 - v / s.top);
    c.beginPath();
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (let step = stepOf(s.top, GRID), k = 0; k * step <= s.top; ++k) {
      c.moveTo(LEFT, y(k * step));
      c.lineTo(LEFT + room, y(k * step));
      c.fillText(String(Number((k * step).toPrecision(6))), LEFT - 6, y(k * step));
    }
    c.textAlign = 'center';
    for (let t = 0; t <= SECONDS; t += 2) {
      const x = LEFT + room * (1 - t / SECONDS);
      c.moveTo(x, TOP);
      c.lineTo(x, TOP + tall);
      c.fillText(t === 0 ? 'now' : `-${t} s`, x, TOP + tall + BOTTOM / 2 + 2);
    }
    c.stroke();
    c.lineWidth = 1.5;
    const line = (of: { low: Float32Array; high: Float32Array }, colour: string, dash: number[]) => {
      c.strokeStyle = colour;
      c.setLineDash(dash);
      c.beginPath();
      of.low.forEach((low, i) => {
        if (Number.isNaN(low)) return;
        const x = LEFT + (room * (i + 0.5)) / of.low.length,
          joins = i > 0 && !Number.isNaN(of.low[i - 1]);
        if (joins) c.lineTo(x, y(s.scale * low));
        else c.moveTo(x, y(s.scale * low));
        c.lineTo(x, y(s.scale * of.high[i]));
      });
      c.stroke();
    };
    line(curve, this.style.line, []);
    if (again) line(again, this.style.second, [5, 4]);
    c.setLineDash([]);
  }

  /// The least and the largest value of each column of pixels, so that no peak is lost and no more is drawn than is seen.
  private curve(of: Trail, columns: number): { low: Float32Array; high: Float32Array; most: number } {
    const low = new Float32Array(columns).fill(NaN),
      high = new Float32Array(columns).fill(NaN);
    let most = 0;
    for (let i = 0; i < N; ++i) {
      const x = of.at(i);
      if (Number.isNaN(x)) continue;
      const k = Math.floor((i * columns) / N);
      if (!(low[k] <= x)) low[k] = x;
      if (!(high[k] >= x)) high[k] = x;
      if (x > most) most = x;
    }
    return { low, high, most };
  }

  /// again: force, torque and depth of the same ticks as computed again, drawn dashed beside them.
  add(frame: Frame, again: Float32Array | null = null): void {
    const n = frame.ticks.length / TICK;
    for (const s of this.series)
      for (let i = 0; i < n; ++i) {
        s.values.push(frame.ticks[TICK * i + s.pick]);
        if (s.of >= 0) s.again.push(again ? again[3 * i + s.of] : NaN);
      }
    if (n > 0) this.change();
  }

  clear(): void {
    for (const s of this.series) {
      s.values.clear();
      s.again.clear();
    }
    this.change();
  }
  /// For tests: the newest value, in the chart's unit.
  latest(series: number): number {
    return this.series[series].scale * this.series[series].values.at(N - 1);
  }
  /// For tests: the value at which the axis ends.
  top(series: number): number {
    return this.series[series].top;
  }
  latestAgain(series: number): number {
    return this.series[series].scale * this.series[series].again.at(N - 1);
  }
}
