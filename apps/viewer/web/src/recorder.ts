// A recording: frames of touch that can be replayed, saved as a table of ticks, and read back from such a table.
import type { Frame } from './messages';
import { TICK } from './net';

const PER_TICK = ['force_N', 'torque_Nm', 'depth_m', 'cpu_us'];
const VECTORS = ['tool', 'hand', 'force', 'torque', 'point', 'normal'] as const;
const NUMBERS = ['depth', 'contacts', 'object', 'part', 'acted', 'faults', 'late'] as const;
const FLAGS = ['degraded', 'engaged', 'connected'] as const;
const COLUMNS = [
  'tick',
  'time_s',
  ...PER_TICK,
  ...VECTORS.flatMap((v) => ['x', 'y', 'z'].map((c) => `frame_${v}_${c}`)),
  ...Array.from({ length: 9 }, (_, i) => `frame_turn_${Math.floor(i / 3)}${i % 3}`),
  ...NUMBERS.map((n) => `frame_${n}`),
  ...FLAGS.map((n) => `frame_${n}`),
];
const MOST_SECONDS = 600;
const PERIOD = 0.001; // s, a tick of the servo
const SHOWN = 6; // s, the length of the charts
const LIMIT = 8 | 256; // bits of haptic::SafetyStep

export interface Again {
  different: number;
  lost: number;
  largestForce: number;
  rmsForce: number;
  largestDepth: number;
  ticks: Float32Array;
}

/// Reads the bytes of /api/again.
export function readAgain(data: ArrayBuffer): Again {
  const [, , different, lost] = new Uint32Array(data, 0, 4),
    [largestForce, rmsForce, largestDepth] = new Float32Array(data, 16, 3);
  return { different, lost, largestForce, rmsForce, largestDepth, ticks: new Float32Array(data, 28) };
}

/// A stretch of a recording.
export interface Span {
  kind: 'contact' | 'limit' | 'fault';
  from: number;
  to: number;
}

interface Kept {
  at: number;
  frame: Frame;
}

export class Recorder {
  private kept: Kept[] = [];
  private began = 0; ///< ms, by the page's clock
  private timer = 0;
  private shift = 0; ///< s, added to the servo's clock
  recording = false;
  /// The forces that the program has computed again from the same poses, if it has.
  again: Again | null = null;
  replaying = false;
  onFrame: (frame: Frame, at: number, of: number) => void = () => {};
  paused = false; ///< replaying, and standing still
  position = 0; ///< s, of a replay
  onSeek: (frames: Frame[], at: number) => void = () => {};
  onEnd: () => void = () => {};
  onFull: () => void = () => {}; ///< the recording has its largest length

  get seconds(): number {
    return this.kept.length ? this.kept[this.kept.length - 1].at : 0;
  }
  get count(): number {
    return this.kept.length;
  }
  /// The first object that is touched; -1: none.
  get touched(): number {
    return this.kept.find((k) => k.frame.object >= 0)?.frame.object ?? -1;
  }

  start(): void {
    this.kept = [];
    this.position = 0;
    this.again = null;
    this.recording = true;
    this.shift = 0;
    this.began = performance.now();
  }
  stop(): void {
    this.recording = false;
  }

  add(frame: Frame): void {
    // Frames of before the program began to record are no part of the recording: both begin with the same tick.
    if (!this.recording || (!this.kept.length && frame.recorded === 0)) return;
    // Another touch begins its clock anew: its time goes on from what is kept.
    const last = this.kept.at(-1)?.frame;
    if (last && frame.time + this.shift <= last.time) this.shift = last.time + (last.ticks.at(-1) ?? 0) + 0.001 - frame.time;
    if (performance.now() - this.began > 1000 * MOST_SECONDS) {
      this.onFull();
      return;
    }
    const time = frame.time + this.shift,
      begin = this.kept[0]?.frame.time ?? time;
    this.kept.push({ at: time + (frame.ticks.at(-1) ?? 0) - begin, frame: { ...frame, time, ticks: frame.ticks.slice() } });
  }

  /// Replays the recording in its own time, from its present position, or from the beginning where it had ended.
  replay(): void {
    if (!this.kept.length) return;
    this.recording = false;
    this.replaying = true;
    this.paused = false;
    if (this.position >= this.seconds) this.position = 0;
    const began = performance.now() - 1000 * this.position;
    let next = this.kept.findIndex((k) => k.at >= this.position);
    cancelAnimationFrame(this.timer);
    const step = () => {
      this.position = Math.min((performance.now() - began) / 1000, this.seconds);
      while (next < this.kept.length && this.kept[next].at <= this.position)
        this.onFrame(this.kept[next++].frame, this.position, this.seconds);
      if (next >= this.kept.length) {
        this.halt();
        return;
      }
      this.timer = requestAnimationFrame(step);
    };
    step();
  }
  /// Goes to a moment and stands still; onSeek gets the frames of the seconds before, the last of which is that moment's.
  seek(to: number): void {
    if (!this.kept.length) return;
    this.pause();
    this.position = Math.max(0, Math.min(to, this.seconds));
    this.onSeek(
      this.kept
        .filter((k) => k.at <= this.position && k.at > this.position - SHOWN)
        .map((k) => k.frame)
        .concat(this.position < this.kept[0].at ? [this.kept[0].frame] : []),
      this.position,
    );
  }
  pause(): void {
    cancelAnimationFrame(this.timer);
    this.recording = false;
    this.replaying = this.paused = this.kept.length > 0;
  }
  halt(): void {
    if (!this.replaying) return;
    cancelAnimationFrame(this.timer);
    this.replaying = this.paused = false;
    this.onEnd();
  }

  /// Stretches that a reader may look for: every contact, the force limit at work, a fault that the filter found. From and to: s. A
  /// tick touches where it has a depth; what else a frame says is about its last tick.
  spans(): Span[] {
    const out: Span[] = [],
      open: Partial<Record<Span['kind'], Span>> = {},
      begin = this.kept[0]?.frame.time ?? 0;
    const mark = (kind: Span['kind'], is: boolean, from: number, to: number) => {
      const span = open[kind];
      if (is && span) span.to = to;
      else if (is) out.push((open[kind] = { kind, from, to }));
      else delete open[kind];
    };
    let before = 0;
    for (const { at, frame } of this.kept) {
      const n = frame.ticks.length / TICK;
      for (let i = 0; i < n; ++i) {
        const from = frame.time - begin + frame.ticks[TICK * i + 4];
        mark('contact', frame.ticks[TICK * i + 2] > 0 || (i === n - 1 && frame.contacts > 0), from, from + PERIOD);
      }
      for (const [kind, is] of [
        ['limit', frame.contacts > 0 && (frame.acted & LIMIT) > 0],
        ['fault', frame.faults > 0],
      ] as const)
        mark(kind, is, before, at);
      before = at;
    }
    return out.sort((a, b) => a.from - b.from);
  }

  /// The table: a row for each tick, numbered and timed as the rows of the program's own recording; a tick that it did not keep goes
  /// on from there. The columns of a frame are filled in the row of its last tick.
  csv(): string {
    const rows = [COLUMNS.join(',')],
      blank = ','.repeat(COLUMNS.length - 2 - PER_TICK.length);
    const short = (x: number) => String(Number(x.toPrecision(9)));
    let tick = 0;
    const begin = this.kept[0]?.frame.time ?? 0;
    for (const { frame } of this.kept) {
      const n = frame.ticks.length / TICK;
      if (frame.recorded >= n) tick = frame.recorded - n;
      for (let i = 0; i < n; ++i) {
        const at = TICK * i,
          own = [
            tick++,
            (frame.time - begin + frame.ticks[at + 4]).toFixed(6),
            ...Array.from(frame.ticks.subarray(at, at + 4), short),
          ].join(',');
        rows.push(
          i < n - 1
            ? own + blank
            : [
                own,
                ...VECTORS.flatMap((v) => frame[v].map(short)),
                ...frame.turn.map(short),
                ...NUMBERS.map((k) => short(frame[k])),
                ...FLAGS.map((k) => Number(frame[k])),
              ].join(','),
        );
      }
    }
    return rows.join('\n') + '\n';
  }

  /// Reads such a table. Throws an error that says what is wrong.
  open(text: string): void {
    const lines = text.trim().split('\n');
    if (lines[0]?.trim() !== COLUMNS.join(',')) throw new Error('it is no recording of this page: its columns are others');
    const kept: Kept[] = [];
    let ticks: number[] = [],
      begun = 0;
    lines.slice(1).forEach((line, row) => {
      const cells = line.split(','),
        wrong = () => new Error(`row ${row + 2} of the recording is not as it should be`);
      if (cells.length !== COLUMNS.length) throw wrong();
      const number = (i: number) => {
        const x = Number(cells[i]);
        if (cells[i].trim() === '' || !Number.isFinite(x)) throw wrong();
        return x;
      };
      if (!ticks.length) begun = number(1);
      const since = number(1) - begun;
      if (since < 0) throw wrong();
      for (let i = 0; i < 4; ++i) ticks.push(number(2 + i));
      ticks.push(since);
      let at = 2 + PER_TICK.length;
      if (cells[at] === '') return;
      const take = (n: number) => Array.from({ length: n }, () => number(at++));
      const frame = { time: begun, ticks: Float32Array.from(ticks), recorded: 0 } as Frame;
      for (const v of VECTORS) frame[v] = take(3);
      frame.turn = take(9);
      for (const k of NUMBERS) frame[k] = number(at++);
      for (const k of FLAGS) frame[k] = number(at++) > 0;
      const time = number(1) - (kept[0]?.frame.time ?? begun);
      if (kept.length && time < kept[kept.length - 1].at) throw wrong();
      kept.push({ at: time, frame });
      ticks = [];
    });
    if (!kept.length) throw new Error('the recording is empty');
    this.replace(kept);
  }

  /// Takes the frames that the program has recorded.
  take(frames: Frame[]): void {
    const last = (f: Frame) => f.time + (f.ticks.at(-1) ?? 0);
    let shift = 0,
      before = 0;
    this.replace(
      frames.map((f) => {
        // Another touch begins its clock anew.
        if (f.time + shift < before) shift = before + 0.001 - f.time;
        before = last(f) + shift;
        return { at: before - frames[0].time, frame: { ...f, time: f.time + shift } };
      }),
    );
  }

  private replace(kept: Kept[]): void {
    this.halt();
    this.recording = false;
    this.kept = kept;
    this.position = 0;
    this.again = null;
  }

  /// Forgets what only the program knew, since it has been started anew.
  forget(): void {
    for (const k of this.kept) k.frame.recorded = 0;
    this.again = null;
  }

  /// Force, torque and depth of a frame's ticks as computed again; null where they were not.
  againOf(frame: Frame): Float32Array | null {
    const n = frame.ticks.length / TICK,
      end = frame.recorded;
    return this.again && end >= n && end <= this.again.ticks.length / 3 ? this.again.ticks.subarray(3 * (end - n), 3 * end) : null;
  }
  /// The seconds whose ticks the program has recorded with their poses.
  get known(): number {
    return this.kept.reduce((at, k) => (k.frame.recorded > 0 ? k.at : at), 0);
  }
}
