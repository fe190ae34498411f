// What was felt in the last seconds, a value a tick.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { h } from './dom';
import { meter } from './meter';
import { TICK, type Frame } from './net';

const SECONDS = 6, RATE = 1000, N = SECONDS * RATE;

interface Series { title: string; scale: number; least: number; pick: number; plot: uPlot | null; values: Float64Array; again: Float64Array; of: number; box: HTMLElement; cursor: HTMLElement; now: HTMLElement; unit: string; }

/// Of both lines; where nothing was computed again there is no number.
function peak(s: Series): number {
  let most = 0;
  for (const line of [s.values, s.again]) for (const x of line) if (x > most) most = x;
  return most;
}

export class Charts {
  readonly element: HTMLElement;
  private series: Series[];
  private x = Float64Array.from({ length: N }, (_, i) => (i - N) / RATE);
  private dirty = false;
  private drawn = 0;
  private seen = false;

  constructor() {
    const make = (title: string, unit: string, pick: number, scale: number, least: number, of = -1): Series => {
      const now = h('span', { class: 'chart-now' }, '0');
      const box = h('div', { class: 'chart-box' });
      return { title, unit, pick, scale, least, plot: null, values: new Float64Array(N), again: new Float64Array(N).fill(NaN), of, box, cursor: h('div', { class: 'cursor', hidden: true }), now };
    };
    this.series = [
      make('Force', 'N', 0, 1, 2, 0), make('Depth', 'mm', 2, 1000, 2, 2), make('Torque', 'mN m', 1, 1000, 2, 1), make('CPU a tick', 'µs', 3, 1, 100),
    ];
    this.element = h('section', { class: 'charts', 'aria-label': 'Strip charts of the last six seconds' },
      ...this.series.map((s) => h('figure', { class: 'chart' }, h('figcaption', {}, h('span', {}, s.title), s.now, h('span', { class: 'unit' }, s.unit)), s.box)));
    new ResizeObserver(() => this.layout()).observe(this.element);
    for (const s of this.series) s.box.append(s.cursor);
    this.element.addEventListener('pointermove', (e) => this.point(e, false));
    this.element.addEventListener('pointerdown', (e) => this.point(e, true));
    this.element.addEventListener('pointerleave', () => { for (const s of this.series) s.cursor.hidden = true; });
  }

  onPick: (secondsAgo: number) => void = () => {};  ///< a moment of the charts is chosen

  /// One cursor through all of them.
  private point(e: PointerEvent, picks: boolean): void {
    const over = this.series.find((s) => s.box.contains(e.target as Node))?.plot?.over.getBoundingClientRect();
    for (const s of this.series) s.cursor.hidden = !over;
    if (!over) return;
    const share = Math.min(Math.max((e.clientX - over.left) / over.width, 0), 1);
    for (const s of this.series) {
      const own = s.plot?.over.getBoundingClientRect(), box = s.box.getBoundingClientRect();
      if (own) s.cursor.style.transform = `translateX(${(own.left - box.left + share * own.width).toFixed(1)}px)`;
    }
    if (picks) this.onPick((1 - share) * SECONDS);
  }

  theme(): void { for (const s of this.series) { s.plot?.destroy(); s.plot = null; } this.layout(); }

  private layout(): void {
    this.seen = !!this.element.offsetParent;
    if (!this.seen) return;
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue('--soft').trim(), line = style.getPropertyValue('--accent').trim(), grid = style.getPropertyValue('--line').trim(), second = style.getPropertyValue('--second').trim();
    for (const s of this.series) {
      const size = { width: Math.max(s.box.clientWidth, 60), height: Math.max(s.box.clientHeight, 40) };
      if (s.plot) { s.plot.setSize(size); continue; }
      s.plot = new uPlot({
        ...size, cursor: { show: false }, legend: { show: false }, padding: [9, 14, 0, 0],
        scales: { x: { time: false, range: [-SECONDS, 0] }, y: { range: () => [0, Math.max(s.least, 1.15 * peak(s))] } },
        axes: [
          { stroke: ink, grid: { stroke: grid, width: 1 }, ticks: { show: false }, size: 20, font: '11px system-ui', values: (_u, v) => v.map((x) => (x === 0 ? 'now' : `${x} s`)) },
          { stroke: ink, grid: { stroke: grid, width: 1 }, ticks: { show: false }, size: 34, font: '11px system-ui' },
        ],
        series: [{}, { stroke: line, width: 1.5, points: { show: false } }, { stroke: second, width: 1.5, dash: [5, 4], points: { show: false } }],
      }, [this.x, s.values, s.again] as unknown as uPlot.AlignedData, s.box);
    }
  }

  /// Every animation frame; draws twenty times a second.
  frame(now: number): void {
    if (!this.dirty || now - this.drawn < 48 || !this.seen) return;
    this.drawn = now;
    this.dirty = false;
    ++meter.chartDraws;
    for (const s of this.series) s.now.textContent = s.values[N - 1].toFixed(s.pick === 3 ? 0 : 2);
    for (const s of this.series) s.plot?.setData([this.x, s.values, s.again] as unknown as uPlot.AlignedData);
  }

  /// again: force, torque and depth of the same ticks as computed again, drawn dashed beside them.
  add(frame: Frame, again: Float32Array | null = null): void {
    const n = frame.ticks.length / TICK;
    if (n === 0) return;
    for (const s of this.series) {
      s.values.copyWithin(0, n);
      for (let i = 0; i < n; ++i) s.values[N - n + i] = s.scale * frame.ticks[TICK * i + s.pick];
      if (s.of < 0) continue;
      s.again.copyWithin(0, n);
      for (let i = 0; i < n; ++i) s.again[N - n + i] = again ? s.scale * again[3 * i + s.of] : NaN;
    }
    this.dirty = true;
  }

  clear(): void { for (const s of this.series) { s.values.fill(0); s.again.fill(NaN); } this.dirty = true; }
  latest(series: number): number { return this.series[series].values[N - 1]; }
  /// Where the axis ends.
  top(series: number): number { return this.series[series].plot?.scales.y.max ?? 0; }
  latestAgain(series: number): number { return this.series[series].again[N - 1]; }
}
