// A sweep of the press: twenty depths at one position, each until the tool has come to rest.
import { announce, h, save } from '../dom';
import { onFelt } from '../felt';
import type { Frame } from '../messages';
import { TICK } from '../net';
import { trouble } from '../notices';
import { hand } from '../stage';
import { on, state } from '../state';
import { onStop } from '../stop';
import { onTheme } from '../theme';
import { csv, drawing, summary, SweepPlot, type Swept } from './sweep_plot';

const COUNT = 20,
  STEP = 0.001; // depths; m from one to the next
const FRAMES = 12; // that have to be alike for a depth to count as still
const SAME = 0.003,
  FLAT = 2e-5; // by how much their force, N, and their depth, m, may differ
const GOES = 1e-4,
  LATEST = 8000; // m that the tool goes deeper before it can be still; ms to wait for that
const MOST_TRIES = 8; // times that a fault of a busy machine is lifted from
const LIMIT = 8 | 256; // bits of haptic::SafetyStep

const mean = (values: number[]): number => values.reduce((sum, x) => sum + x, 0) / Math.max(values.length, 1);
/// A value of the ticks of these frames: force 0, torque 1, depth 2.
const values = (frames: Frame[], which: number): number[] =>
  frames.flatMap((f) => Array.from({ length: f.ticks.length / TICK }, (_, i) => f.ticks[TICK * i + which]));

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
  private plot = new SweepPlot();
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
    h('button', { id: 'sweep-table', onclick: () => save('force-depth.csv', csv(this.kept), 'text/csv') }, 'Table'),
    h('button', { id: 'sweep-drawing', onclick: () => save('force-depth.svg', drawing(this.kept), 'image/svg+xml') }, 'SVG'),
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
    this.plot.element as unknown as HTMLElement,
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
    const text = done.rows.length ? `${why} ${summary(done)}`.trim() : why;
    this.show(text);
    if (done.rows.length) announce(text);
    else trouble(text);
  }

  private show(text?: string): void {
    const all = this.now ? [...this.kept, this.now] : this.kept,
      some = all.some((s) => s.rows.length > 0);
    this.button.textContent = this.running ? 'End the sweep' : 'Sweep 20 depths';
    this.button.disabled = state.playing || !state.facts.length;
    for (const b of this.keep) b.hidden = !this.kept.length || this.running;
    if (text !== undefined || !some) this.words.textContent = text ?? '';
    this.plot.show(all);
  }
}

export const sweep = new Sweep();
