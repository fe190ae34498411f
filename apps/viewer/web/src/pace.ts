// How finely the stage is drawn while it moves: as finely as frames come in time, and in full once it is still.

const SLOW = 20;      // ms a frame, mean: more is too slow for 60 a second
const COUNT = 24;     // frames that a mean is taken of
const COARSEST = 0.5; // of the screen's own pixels
const STILL = 200;    // ms without a change

export class Pace {
  on = true;
  private moving = 1;     ///< share of the pixels along each side while things move
  private sum = 0;
  private frames = 0;
  private before = 0;     ///< mean before the last step down
  private helps = true;   ///< whether fewer pixels made frames faster: not where a screen or a busy machine sets the pace
  private last = 0;

  /// Of a frame about to be drawn: the share of pixels that it gets.
  next(now: number): number {
    const took = now - this.last, goesOn = this.last > 0 && took < STILL;
    this.last = now;
    if (!this.on) return 1;
    if (!goesOn) { this.sum = this.frames = 0; return this.moving; }
    this.sum += Math.min(took, 3 * SLOW);  // one long wait is no pace
    if (++this.frames < COUNT) return this.moving;
    const mean = this.sum / this.frames;
    this.sum = this.frames = 0;
    if (this.before > 0 && mean > 0.93 * this.before) {  // the step down was in vain
      this.moving = Math.min(1, this.moving / 0.75);
      this.helps = false;
    } else if (mean > SLOW && this.helps && this.moving > COARSEST) {
      this.moving = Math.max(COARSEST, 0.75 * this.moving);
      this.before = mean;
      return this.moving;
    }
    this.before = 0;
    return this.moving;
  }

  /// Whether what was drawn coarsely is to be drawn in full now.
  still(now: number): boolean { return this.on && this.last > 0 && now - this.last > STILL; }

  /// After a rest one try at more pixels: a machine that was busy for a while is not so for ever.
  rested(): void {
    this.moving = Math.min(1, 1.1 * this.moving);
    this.helps = true;
    this.before = this.last = 0;
  }
}
