// Turns pointer and keys into the position where the hand wants the tool. The program moves the tool there and computes the force.
import * as THREE from 'three';
import type { Hit } from './objects';
import type { World } from './world';

const LIFT = 0.018; // m above the surface when let go
const LEAST_PRESS = -0.005,
  LARGEST_PRESS = 0.02; // m
const NUMB = 700; // ms without a force, until it is lifted

export class Hand {
  press = 0.006; ///< m below the surface that the hand wants to be
  only = -1; ///< one object alone, or all
  enabled = false; ///< touch mode
  private held = false;
  private lastPoint = new THREE.Vector3();
  private lastNormal = new THREE.Vector3(0, 0, 1);
  private at = new THREE.Vector2();
  private target = new THREE.Vector3();
  onAim: (target: THREE.Vector3, held: boolean, hit: Hit | null) => void = () => {};
  onKeyTouch: (text: string) => void = () => {};
  onAsk: () => void = () => {}; ///< the user wants to hear the touched part and the force

  constructor(
    private world: World,
    private canvas: HTMLCanvasElement,
  ) {
    canvas.addEventListener('pointerdown', (e) => this.down(e), { capture: true });
    canvas.addEventListener('pointermove', (e) => {
      if (this.held && this.drags) {
        this.at.copy(this.world.onCanvas(e));
        this.aim();
      }
    });
    const up = (e: PointerEvent) => {
      if (this.drags && e.type !== 'pointerleave') this.letGo();
    };
    canvas.addEventListener('pointerup', up);
    canvas.addEventListener('pointercancel', up);
    canvas.addEventListener(
      'wheel',
      (e) => {
        if (!this.held) return;
        e.preventDefault();
        e.stopImmediatePropagation();
        this.deeper(e.deltaY < 0 ? 0.0005 : -0.0005);
      },
      { capture: true, passive: false },
    );
    canvas.addEventListener('keydown', (e) => this.key(e));
    // The tool stays while the user works at the sliders, so that their effect can be touched; Space lets go from there, too.
    canvas.addEventListener('blur', (e) => {
      if (!this.held || this.drags) return;
      if (e.relatedTarget instanceof Element && e.relatedTarget.closest('#panel')) this.onKeyTouch('Still touching. Space stops.');
      else this.letGo();
    });
  }

  private drags = false;
  private inSpace = false; ///< a hand in space holds the tool, and lifts it without help
  get holding(): boolean {
    return this.held;
  }
  /// The position that the hand wants; null where it holds nothing, or is above the surface until the program has the tool.
  get wanted(): THREE.Vector3 | null {
    return this.held && !this.downAt ? this.target : null;
  }

  /// The position on the surface that the hand points at, m.
  get point(): number[] {
    return this.lastPoint.toArray();
  }

  private down(e: PointerEvent): void {
    if (!this.enabled || e.button !== 0 || e.ctrlKey || e.shiftKey) return;
    this.at.copy(this.world.onCanvas(e));
    // Beside the objects a drag turns the view, as it does in Look.
    if (!this.world.cast(this.at.x, this.at.y, this.only) && !this.world.objects.hidden) return;
    e.stopImmediatePropagation();
    this.canvas.focus();
    this.canvas.setPointerCapture(e.pointerId);
    this.drags = true;
    this.begin();
  }

  /// Takes the tool up off the surface, so that the force can come in gently; aim() then brings it down.
  private begin(): void {
    this.held = true;
    const hit = this.world.cast(this.at.x, this.at.y, this.only);
    if (hit) {
      this.lastPoint.copy(hit.point);
      this.lastNormal.copy(hit.normal);
      // A mesh is lifted towards the eye, where nothing can be in between.
      const span = this.world.tool.span(),
        way = span > 0 ? this.world.camera.position.clone().sub(hit.point).normalize() : hit.normal;
      this.over(hit.point, hit.normal, 0).addScaledVector(way, LIFT + span);
    } else this.target.copy(this.world.beside(this.at.x, this.at.y, this.lastPoint));
    this.onAim(this.target, true, hit);
    this.downAt = performance.now() + 60;
    setTimeout(() => {
      if (this.held && this.downAt > 0) {
        this.downAt = 0;
        this.aim();
      }
    }, 1000);
  }

  /// Sets the target so that the first point of the tool to touch stands that high above a point.
  private over(point: THREE.Vector3, normal: THREE.Vector3, height: number): THREE.Vector3 {
    return this.target.copy(point).sub(this.world.tool.tip(normal)).addScaledVector(normal, height);
  }

  private aim(): void {
    if (this.downAt) return;
    const hit = this.world.cast(this.at.x, this.at.y, this.only);
    if (hit) {
      this.lastPoint.copy(hit.point);
      this.lastNormal.copy(hit.normal);
      this.over(hit.point, hit.normal, -this.press);
    } else {
      this.target.copy(this.world.beside(this.at.x, this.at.y, this.lastPoint));
    }
    this.onAim(this.target, this.held, hit);
  }

  private downAt = 0;
  private numbSince = 0;
  /// Goes down to the surface as soon as the program has engaged the tool. numb: the tool touches without a force, since it came to
  /// the surface before it was engaged; then it goes up and down again, which a slow machine would else leave to the user.
  heard(engaged: boolean, numb: boolean): void {
    if (this.inSpace) return;
    const now = performance.now();
    if (this.downAt) {
      if (!engaged || now < this.downAt) return;
      this.downAt = 0;
      if (this.held) this.aim();
      return;
    }
    if (!this.held || !numb) {
      this.numbSince = 0;
      return;
    }
    this.numbSince ||= now;
    if (now - this.numbSince < NUMB) return;
    this.numbSince = 0;
    this.begin();
  }

  /// Says where the nearest object is on the screen when the hand is over none, so that the arrow keys find it.
  private seek(): void {
    if (this.world.cast(this.at.x, this.at.y, this.only)) {
      this.onSeek(null, 0, '');
      return;
    }
    const near = this.world.nearestOnScreen(this.at, this.only);
    if (!near) return;
    const dx = near.x - this.at.x,
      dy = near.y - this.at.y,
      words: string[] = [];
    if (Math.abs(dy) > 0.04) words.push(dy > 0 ? 'up' : 'down');
    if (Math.abs(dx) > 0.04) words.push(dx > 0 ? 'right' : 'left');
    this.onSeek(near.object, Math.hypot(dx, dy), words.join(' and ') || 'close by');
  }
  /// distance: on the screen, 0 to 2; object null: there is something under the hand.
  onSeek: (object: number | null, distance: number, direction: string) => void = () => {};

  deeper(by: number): void {
    this.press = Math.min(Math.max(this.press + by, LEAST_PRESS), LARGEST_PRESS);
    if (this.held) this.aim();
    this.onPress();
  }
  onPress: () => void = () => {}; ///< another depth is wanted

  /// Takes the tool up again after a lost connection.
  again(): void {
    if (this.held) this.begin();
  }
  /// Tells whether the tool is held and the program has not engaged it yet.
  get waits(): boolean {
    return this.held && this.downAt > 0;
  }

  letGo(): void {
    if (!this.held) return;
    this.held = this.drags = this.inSpace = false;
    this.downAt = 0;
    this.over(this.lastPoint, this.lastNormal, LIFT);
    this.onAim(this.target, false, null);
  }

  /// Takes the tool by the keyboard, in the middle of the view or where the tool was.
  hold(): void {
    this.drags = false;
    this.held = true;
    if (!this.world.cast(this.at.x, this.at.y, this.only)) this.toMiddle();
    this.begin();
  }

  /// The next touch by keys begins in the middle of the view.
  toMiddle(): void {
    this.at.copy(this.world.project(this.world.controls.target));
    this.lastPoint.copy(this.world.controls.target);
  }

  /// Touches the surface, or lifts the tool.
  toggle(): void {
    if (this.held) {
      this.letGo();
      this.onKeyTouch('Lifted');
      return;
    }
    this.hold();
    this.onKeyTouch('Touching');
    this.seek();
  }

  /// Moves the hand over the stage, by shares of half its height; takes the tool up where it is not held.
  moveBy(right: number, up: number): void {
    if (!this.held) {
      this.hold();
      return;
    }
    this.at.set(Math.min(Math.max(this.at.x + right / this.world.camera.aspect, -1), 1), Math.min(Math.max(this.at.y + up, -1), 1));
    this.aim();
    this.seek();
  }

  /// Moves the tool to a point of the world, for a hand in space, which no surface stops.
  moveTo(target: THREE.Vector3): void {
    this.drags = false;
    this.held = this.inSpace = true;
    this.downAt = 0;
    this.lastPoint.copy(this.target.copy(target));
    this.onAim(this.target, true, null);
  }

  private key(e: KeyboardEvent): void {
    if (!this.enabled) return;
    const step = e.shiftKey ? 0.006 : 0.024;
    const moves: Record<string, [number, number]> = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, step],
      ArrowDown: [0, -step],
    };
    const move = moves[e.key],
      letter = e.key.length === 1 ? e.key.toLowerCase() : e.key; // Shift and Caps Lock make no difference
    if (move) {
      e.preventDefault();
      e.stopPropagation();
      this.moveBy(move[0], move[1]);
    } else if (e.key === 'Enter') {
      e.preventDefault();
      this.toggle();
    } else if (e.key === 'PageDown' || e.key === 'PageUp') {
      e.preventDefault();
      this.deeper(e.key === 'PageDown' ? 0.0005 : -0.0005);
      this.onKeyTouch(`Press ${(1000 * this.press).toFixed(1)} millimetres`);
    } else if (letter === 'n') {
      this.onAsk();
    } else if (letter === 'q' || letter === 'e') {
      this.world.walk(letter);
      this.onKeyTouch(letter === 'q' ? 'Turned 15 degrees left' : 'Turned 15 degrees right');
      if (this.held) this.aim();
    }
  }
}
