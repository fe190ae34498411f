// Chooses the resolution of the stage: while it moves, as fine as frames come in time; in full once it is still.

const SLOW = 20; // ms a frame, median: more is too slow for 60 a second
const COUNT = 24; // frames that the median is taken of,
const LONG = 600; // or as many as come in so many ms,
const FEWEST = 5; // but at least so many
const COARSEST = 0.5; // of the screen's own pixels
export const STILL = 200; // ms without a change
const PAUSE = 1000; // ms: after a longer wait nothing was moving

export class Pace {
  on = true;
  private moving = 1; ///< share of the pixels along each side while things move
  private times: number[] = [];
  private sum = 0;
  private before = 0; ///< median before the last step down
  private helps = true; ///< fewer pixels make frames faster; false where the screen or a busy machine sets the pace
  private last = 0;

  /// The share of pixels along each side that the next frame gets.
  next(now: number): number {
    const took = now - this.last,
      goesOn = this.last > 0 && took < PAUSE;
    this.last = now;
    if (!this.on) return 1;
    if (!goesOn) {
      this.forget();
      return this.moving;
    }
    this.times.push(took);
    this.sum += took;
    if (this.times.length < COUNT && (this.times.length < FEWEST || this.sum < LONG)) return this.moving;
    const median = this.times.sort((a, b) => a - b)[this.times.length >> 1]; // a single long wait does not count
    this.forget();
    if (this.before > 0 && median > 0.93 * this.before) {
      // fewer pixels have not helped
      this.moving = Math.min(1, this.moving / 0.75);
      this.helps = false;
    } else if (median > SLOW && this.helps && this.moving > COARSEST) {
      // Without a graphics card nearly all time goes into pixels, so that the step is as large as the frame is too slow.
      this.moving = Math.max(COARSEST, this.moving * Math.max(0.6, Math.min(0.75, Math.sqrt(SLOW / median))));
      this.before = median;
      return this.moving;
    }
    this.before = 0;
    return this.moving;
  }

  /// Tells whether still() has yet to say so.
  get waits(): boolean {
    return this.on && this.last > 0;
  }

  private forget(): void {
    this.times = [];
    this.sum = 0;
  }

  /// Tells whether the stage has been still long enough to be drawn in full.
  still(now: number, wait = STILL): boolean {
    return this.on && this.last > 0 && now - this.last > wait;
  }

  /// Tries more pixels after a rest: a machine that was busy may be free again.
  rested(): void {
    this.moving = Math.min(1, 1.1 * this.moving);
    this.helps = true;
    this.before = this.last = 0;
    this.forget();
  }
}
