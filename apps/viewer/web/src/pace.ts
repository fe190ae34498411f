// How finely the stage is drawn while it moves: as finely as frames come in time, and in full once it is still.

const SLOW = 20;      // ms a frame, median: more is too slow for 60 a second
const COUNT = 24;     // frames that the median is taken of,
const LONG = 600;     // or as many as come in so many ms,
const FEWEST = 5;     // but so many at least
const COARSEST = 0.5; // of the screen's own pixels
const STILL = 200;    // ms without a change
const PAUSE = 1000;   // ms: a frame that took longer was waited for

export class Pace {
  on = true;
  private moving = 1;     ///< share of the pixels along each side while things move
  private times: number[] = [];
  private sum = 0;
  private before = 0;     ///< median before the last step down
  private helps = true;   ///< whether fewer pixels made frames faster: not where a screen or a busy machine sets the pace
  private last = 0;

  /// Of a frame about to be drawn: the share of pixels that it gets.
  next(now: number): number {
    const took = now - this.last, goesOn = this.last > 0 && took < PAUSE;
    this.last = now;
    if (!this.on) return 1;
    if (!goesOn) { this.forget(); return this.moving; }
    this.times.push(took);
    this.sum += took;
    if (this.times.length < COUNT && (this.times.length < FEWEST || this.sum < LONG)) return this.moving;
    const median = this.times.sort((a, b) => a - b)[this.times.length >> 1];  // one long wait is no pace
    this.forget();
    if (this.before > 0 && median > 0.93 * this.before) {  // the step down was in vain
      this.moving = Math.min(1, this.moving / 0.75);
      this.helps = false;
    } else if (median > SLOW && this.helps && this.moving > COARSEST) {
      // A machine without a graphics card is far too slow: by as much as it is, since pixels are most of what it draws.
      this.moving = Math.max(COARSEST, this.moving * Math.max(0.6, Math.min(0.75, Math.sqrt(SLOW / median))));
      this.before = median;
      return this.moving;
    }
    this.before = 0;
    return this.moving;
  }

  private forget(): void { this.times = []; this.sum = 0; }

  /// Whether what was drawn coarsely is to be drawn in full now.
  still(now: number, wait = STILL): boolean { return this.on && this.last > 0 && now - this.last > wait; }

  /// After a rest one try at more pixels: a machine that was busy for a while is not so for ever.
  rested(): void {
    this.moving = Math.min(1, 1.1 * this.moving);
    this.helps = true;
    this.before = this.last = 0;
    this.forget();
  }
}
