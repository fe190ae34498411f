// The cost of a frame of the page: time between frames, time of its own scripts, draw calls, bytes of messages.

const KEPT = 240; // frames

type Kind = 'message' | 'draw' | 'charts' | 'colours';

class Meter {
  private between: number[] = [];
  private work: number[] = [];
  private spent = 0;
  private last = 0;
  readonly kinds: Record<Kind, { ms: number; times: number }> = {
    message: { ms: 0, times: 0 },
    draw: { ms: 0, times: 0 },
    charts: { ms: 0, times: 0 },
    colours: { ms: 0, times: 0 },
  };
  // Counts since the page was opened; but calls and triangles are the newest picture's, and lastBytes is the newest message's.
  frames = 0;
  draws = 0;
  calls = 0;
  triangles = 0;
  messages = 0;
  bytes = 0;
  lastBytes = 0;
  coloured = 0; ///< triangles that got a colour
  chartDraws = 0;

  /// Runs work of the page; its time counts for the frame that is being made.
  spend<T>(kind: Kind, work: () => T): T {
    const began = performance.now();
    try {
      return work();
    } finally {
      const took = performance.now() - began;
      this.spent += took;
      this.kinds[kind].ms += took;
      ++this.kinds[kind].times;
    }
  }

  /// A new animation frame begins.
  frame(now: number): void {
    ++this.frames;
    if (this.last > 0) {
      this.between.push(now - this.last);
      this.work.push(this.spent);
      if (this.between.length > KEPT) {
        this.between.shift();
        this.work.shift();
      }
    }
    this.last = now;
    this.spent = 0;
  }

  /// No frame follows: the time until the next one is no cost of a frame.
  rest(): void {
    this.last = 0;
  }

  drawn(calls: number, triangles: number): void {
    ++this.draws;
    this.calls = calls;
    this.triangles = triangles;
  }
  /// Counts a message. every: one of them comes with every frame of the stream; others are counted, but say nothing about a frame.
  heard(bytes: number, every: boolean): void {
    ++this.messages;
    this.bytes += bytes;
    if (every) this.lastBytes = bytes;
  }

  cost() {
    const mean = (x: number[]) => (x.length ? x.reduce((a, b) => a + b, 0) / x.length : 0);
    return {
      frameMs: mean(this.between),
      frameWorstMs: Math.max(0, ...this.between),
      scriptMs: mean(this.work),
      scriptWorstMs: Math.max(0, ...this.work),
      frames: this.frames,
      draws: this.draws,
      calls: this.calls,
      triangles: this.triangles,
      messages: this.messages,
      bytes: this.bytes,
      lastBytes: this.lastBytes,
      coloured: this.coloured,
      chartDraws: this.chartDraws,
    };
  }

  words(): string {
    const c = this.cost();
    if (c.frameMs === 0) return '';
    return (
      `Page: ${(1000 / c.frameMs).toFixed(0)} frames/s, its scripts ${c.scriptMs.toFixed(1)} ms of ${c.frameMs.toFixed(1)} ms a frame (worst ${c.scriptWorstMs.toFixed(1)} of ${c.frameWorstMs.toFixed(0)}); ` +
      `${c.calls} draw calls, ${c.triangles.toLocaleString('en')} triangles; ${c.lastBytes.toLocaleString('en')} bytes a message.`
    );
  }
}

export const meter = new Meter();
