// The scene: camera, light, the loop that draws, the surface under a point of the canvas. World: metres, y up.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { meter } from './meter';
import type { ObjectFacts } from './messages';
import { fullRatio, Objects, type Hit } from './objects';
import { Pace, STILL } from './pace';
import { GroundShadow } from './shadow';
import { Tool } from './tool';
import { Traces } from './traces';

const IN_SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
const SAMPLES = 2; // samples along each side of a pixel, of a still picture drawn in software
const TILE = 2048; // pixels of a picture that are drawn at once, along each side
const LONG = 700; // ms without a change before such a picture: it costs as much as ten others

/// Tells whether the browser draws without a graphics card. Smooth edges then cost more than all else, and only a still picture has
/// them.
function isSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return false;
  const name = gl.getExtension('WEBGL_debug_renderer_info'),
    renderer = String(gl.getParameter(name ? name.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return IN_SOFTWARE.test(renderer);
}

function rendererOf(canvas: HTMLCanvasElement, antialias: boolean): THREE.WebGLRenderer | null {
  try {
    const renderer = new THREE.WebGLRenderer({ canvas, antialias });
    renderer.localClippingEnabled = true;
    renderer.debug.checkShaderErrors = false; // a check would wait for the graphics card
    return renderer;
  } catch {
    return null;
  }
}

const FRONT = new THREE.Vector3(0.28, 0.3, 1).normalize();
const cornersOf = ({ min, max }: THREE.Box3): THREE.Vector3[] =>
  Array.from({ length: 8 }, (_, c) => new THREE.Vector3(c & 1 ? max.x : min.x, c & 2 ? max.y : min.y, c & 4 ? max.z : min.z));

export class World {
  readonly renderer: THREE.WebGLRenderer | null; ///< null: this browser has no WebGL; all but the picture goes on
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.005, 20);
  readonly rig = new THREE.Group(); ///< stands where the floor of a headset's user is, else at the origin
  readonly controls: OrbitControls;
  private scene = new THREE.Scene();
  readonly objects: Objects;
  readonly tool: Tool;
  readonly traces: Traces;
  readonly extra = new THREE.Group(); ///< the figure and its cloth
  private raycaster = new THREE.Raycaster();
  private ground: THREE.GridHelper;
  private shadows: GroundShadow[]; ///< of the only or left view, and of the right one
  onFrame: (now: number) => boolean = () => false; ///< before each draw; true: another frame is wanted
  onImmersive: (frame: XRFrame) => void = () => {}; ///< before that, while a headset shows the scene
  readonly pace = new Pace();
  private software = isSoftware();
  private ratio = 0; ///< pixels of the last picture to one of the page, along each side
  readonly size = new THREE.Vector2(1, 1); ///< the stage's, pixels of the page
  private framed: { again: () => void; at: THREE.Vector3 } | null = null; ///< frames the same again; the eye's position then
  private dirty = true;

  constructor(private canvas: HTMLCanvasElement) {
    this.renderer = rendererOf(canvas, !this.software);
    this.fineness(fullRatio());
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.15;
    this.controls.addEventListener('change', () => this.redraw());
    this.raycaster.firstHitOnly = true;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.9));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.5, 1, 0.8);
    this.camera.add(sun);
    this.rig.add(this.camera);
    this.scene.add(this.rig);
    this.ground = new THREE.GridHelper(2, 40, 0x888888, 0x888888);
    (this.ground.material as THREE.Material).transparent = true;
    (this.ground.material as THREE.Material).opacity = 0.22;
    this.scene.add(this.ground);
    this.shadows = this.renderer ? [0, 1].map(() => new GroundShadow(this.scene, this.renderer!)) : [];
    this.objects = new Objects(this.scene, () => this.redraw());
    this.objects.onPaint = () => this.shade(false);
    this.tool = new Tool(this.scene, () => this.redraw());
    this.traces = new Traces(this.scene, () => this.redraw());
    this.scene.add(this.extra);
    this.camera.position.set(0.25, 0.2, 0.6);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as HTMLElement);
    this.resize();
    this.renderer?.xr.setAnimationLoop(this.step);
    this.renderer?.xr.addEventListener('sessionend', () => {
      this.renderer!.setAnimationLoop(null);
      this.renderer!.xr.setAnimationLoop(this.step);
      this.redraw();
    });
    this.wake();
  }

  private awake = false;
  private rest = 0;
  /// Asks for a frame. The page asks for one after the other only while something changes: a still one costs nothing.
  wake(): void {
    if (this.awake || this.renderer?.xr.isPresenting) return;
    this.awake = true;
    requestAnimationFrame(this.step);
  }

  private step = (now: number, seen?: XRFrame): void => {
    this.awake = false;
    meter.frame(now);
    if (seen) this.onImmersive(seen);
    const more = this.onFrame(now);
    meter.spend('draw', () => {
      if (this.renderer?.xr.isPresenting) {
        this.renderer.render(this.scene, this.camera);
        return;
      }
      this.controls.update();
      if (!this.dirty) {
        if (!this.pace.still(now, this.stillAfter)) return;
        this.pace.rested();
        if (this.ratio === this.finest()) return;
        this.fineness(this.finest());
      } else this.fineness(this.pace.next(now) * fullRatio());
      this.dirty = false;
      if (!this.renderer) return;
      this.tool.turnTo(this.camera);
      this.draw(this.renderer);
    });
    clearTimeout(this.rest);
    if (more || this.dirty) {
      this.wake();
      return;
    }
    meter.rest();
    // A stage that was drawn coarsely is drawn in full once it is still.
    if (this.pace.waits) this.rest = window.setTimeout(() => this.wake(), this.stillAfter + 20);
  };
  private get stillAfter(): number {
    return this.software ? LONG : STILL;
  }

  redraw(): void {
    this.dirty = true;
    this.wake();
  }

  /// Draws each of two views with its own content; view: 0 is the left one.
  private inTurn(draw: (view: number) => void): void {
    (['left', 'right'] as const).forEach((side, view) => {
      const shift = this.objects.show(side);
      this.camera.position.add(shift);
      this.camera.updateMatrixWorld();
      this.showShadow(view);
      draw(view);
      this.camera.position.sub(shift);
    });
    this.objects.show('both');
    this.showShadow(0);
    this.camera.updateMatrixWorld();
  }

  private draw(renderer: THREE.WebGLRenderer): void {
    const { x: wide, y: high } = this.size,
      half = 0.5 * wide,
      { info } = renderer;
    if (!this.split) {
      this.showShadow(0);
      renderer.render(this.scene, this.camera);
      meter.drawn(info.render.calls, info.render.triangles);
      return;
    }
    info.autoReset = false;
    info.reset();
    renderer.setScissorTest(true);
    this.inTurn((view) => {
      renderer.setViewport(view * half, 0, half, high);
      renderer.setScissor(view * half, 0, half, high);
      renderer.render(this.scene, this.camera);
    });
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, wide, high);
    info.autoReset = true;
    meter.drawn(info.render.calls, info.render.triangles);
  }

  private split = false;
  /// Shows two views side by side, as Objects.beside says, from one eye.
  setSplit(yes: boolean): void {
    if (yes === this.split) return;
    this.split = yes;
    this.resize();
    this.shade();
  }
  get halved(): boolean {
    return this.split;
  }
  /// Pixels of the page across one view.
  private get across(): number {
    return this.split ? 0.5 * this.size.x : this.size.x;
  }

  private fineness(ratio: number): void {
    if (ratio === this.ratio) return;
    this.ratio = ratio;
    this.renderer?.setPixelRatio(ratio); // sets the size as well
  }
  /// The pixels of a still picture.
  finest(): number {
    return this.software ? Math.max(SAMPLES, fullRatio()) : fullRatio();
  }

  theme(): void {
    const style = getComputedStyle(document.documentElement);
    this.scene.background = new THREE.Color(style.getPropertyValue('--stage').trim());
    this.redraw();
  }

  private resize(): void {
    const box = (this.canvas.parentElement as HTMLElement).getBoundingClientRect();
    if (box.width < 2 || box.height < 2 || this.renderer?.xr.isPresenting) return;
    this.size.set(box.width, box.height);
    this.renderer?.setSize(box.width, box.height, false);
    this.camera.aspect = this.across / box.height;
    this.camera.updateProjectionMatrix();
    // A view that nobody has turned since stays framed.
    if (this.framed && this.framed.at.distanceTo(this.camera.position) < 1e-6) this.framed.again();
    this.redraw();
  }

  /// Draws these objects, over the ground.
  async setScene(facts: ObjectFacts[]): Promise<void> {
    const drawn = this.objects.set(facts);
    this.groundUnder();
    await drawn;
    this.shade();
  }

  private shaded = '';
  /// Draws the shadow of what is seen on the ground anew, for each view its own; where that is as before, only if it moved.
  shade(moved = true): void {
    const views = this.split ? (['left', 'right'] as const) : (['both'] as const),
      seen = views.map((view) => this.objects.seenIn(view)),
      key = JSON.stringify(seen);
    if (!moved && key === this.shaded) return;
    this.shaded = key;
    this.shadows.forEach((shadow, i) =>
      shadow.draw(
        (seen[i] ?? []).map((object) => this.objects.surfaceOf(object)),
        this.objects.box(),
        this.objects.low - 0.001,
      ),
    );
    this.redraw();
  }
  private figureShadow: GroundShadow | null = null;
  private figureShaded = 0;
  /// Draws the shadow of the figure that is dressed, on the ground at 0; in software a few times a second, else for each frame.
  shadeFigure(surfaces: THREE.Mesh[]): void {
    const now = performance.now();
    if (!this.renderer || now - this.figureShaded < (this.software ? 1000 : 30)) return;
    this.figureShaded = now;
    this.figureShadow ??= new GroundShadow(this.scene, this.renderer, this.software ? 96 : 512);
    const box = new THREE.Box3();
    for (const mesh of surfaces) {
      mesh.geometry.computeBoundingBox();
      box.union(mesh.geometry.boundingBox!);
    }
    this.figureShadow.draw(surfaces, box, 0, 0.35);
    this.figureShadow.seen = true;
  }
  hideFigureShadow(): void {
    if (this.figureShadow) this.figureShadow.seen = false;
  }
  private showShadow(view: number): void {
    this.shadows.forEach((shadow, i) => {
      shadow.seen = i === view;
    });
  }

  /// Brings all objects, or one, into sight. from: the direction of the eye; by default the front, and a little above.
  frame(object = -1, from = FRONT): void {
    this.frameBox(this.objects.box(object), from);
  }
  /// The direction from the middle of the view to the eye.
  direction(): THREE.Vector3 {
    return this.offset.normalize();
  }

  /// Tells whether the box of another object overlaps this object's on the screen.
  crowded(object: number): boolean {
    const own = this.onScreen(object);
    for (let i = 0; i < this.objects.count; ++i) if (i !== object && this.onScreen(i).intersectsBox(own)) return true;
    return false;
  }
  /// Tells whether the middle of an object is on the screen.
  sees(object: number): boolean {
    const p = this.objects.box(object).getCenter(new THREE.Vector3()).project(this.camera);
    return Math.max(Math.abs(p.x), Math.abs(p.y), Math.abs(p.z)) < 1;
  }
  private onScreen(object: number): THREE.Box2 {
    return new THREE.Box2().setFromPoints(cornersOf(this.objects.box(object)).map((p) => this.project(p)));
  }

  /// Frames one object from a side where the others stand behind it, and brings the eye near until its surface fills the view below
  /// the hint.
  frameClosely(object: number): void {
    const own = this.objects.box(object).getCenter(new THREE.Vector3()),
      all = this.objects.box().getCenter(new THREE.Vector3());
    const away = own.clone().sub(all).setY(0),
      from = away.length() > 1e-6 ? away.normalize().setY(0.25).addScaledVector(FRONT, 1.1).normalize() : FRONT;
    this.frame(object, from);
    const points: THREE.Vector3[] = [],
      p = new THREE.Vector3(),
      { target } = this.controls;
    this.objects.eachVertex(object, 7, (_, v) => points.push(v.clone()));
    for (let k = 0; k < 40; ++k) {
      let low = 1,
        high = -1,
        wide = 0;
      for (const v of points) {
        p.copy(v).project(this.camera);
        low = Math.min(low, p.y);
        high = Math.max(high, p.y);
        wide = Math.max(wide, Math.abs(p.x));
      }
      if (!points.length || low < -0.86 || high > 0.74 || wide > 0.9) break;
      this.camera.position.sub(target).multiplyScalar(0.97).add(target);
      this.camera.updateMatrixWorld();
    }
    this.controls.update();
    this.framed = { again: () => this.frameClosely(object), at: this.camera.position.clone() };
    this.redraw();
  }

  /// The point of an object's surface that is highest on the screen, -1 to 1 each way.
  highest(object: number): THREE.Vector2 {
    const top = new THREE.Vector2(0, -Infinity),
      p = new THREE.Vector3();
    this.objects.eachVertex(object, 7, (_, v) => {
      p.copy(v).project(this.camera);
      if (p.y > top.y) top.set(p.x, p.y);
    });
    return Number.isFinite(top.y) ? top : this.project(this.objects.box(object).getCenter(p));
  }

  frameBox(box: THREE.Box3, from = FRONT): void {
    if (box.isEmpty()) box.set(new THREE.Vector3(-0.1, -0.1, -0.1), new THREE.Vector3(0.1, 0.1, 0.1));
    const centre = box.getCenter(new THREE.Vector3()),
      size = box.getSize(new THREE.Vector3()),
      corners = cornersOf(box),
      corner = new THREE.Vector3();
    this.controls.target.copy(centre);
    // The eye goes back until all corners are in sight, with a margin.
    for (let distance = 0.5 * size.length() + 0.02, k = 0; k < 40; ++k, distance *= 1.06) {
      this.camera.position.copy(centre).addScaledVector(from, distance);
      this.camera.lookAt(centre);
      this.camera.updateMatrixWorld();
      let most = 0;
      for (const p of corners) {
        corner.copy(p).project(this.camera);
        most = Math.max(most, Math.abs(corner.x), Math.abs(corner.y), Math.abs(corner.z) > 1 ? 2 : 0);
      }
      if (most < 0.93) break;
    }
    this.controls.update();
    this.framed = { again: () => this.frameBox(box, from), at: this.camera.position.clone() };
    this.camera.updateMatrixWorld();
    this.redraw();
  }

  readonly axes = new THREE.AxesHelper(0.1);
  /// Shows axes at the lower corner of the objects: x red, y green, z blue, 10 cm each.
  showAxes(yes: boolean): void {
    const box = this.objects.box();
    this.axes.position.set(box.min.x, this.objects.low, box.max.z);
    if (yes) this.scene.add(this.axes);
    else this.scene.remove(this.axes);
    this.redraw();
  }

  /// Brings the eye near a point of an object's surface, to a side from which nothing hides the point.
  closeTo(object: number, p: THREE.Vector3, normal: THREE.Vector3): void {
    const size = 0.25 * this.objects.box(object).getSize(new THREE.Vector3()).length(),
      box = new THREE.Box3().setFromCenterAndSize(p, new THREE.Vector3(size, size, size));
    const sides = [normal.clone().normalize()];
    for (let k = 0; k < 60; ++k) {
      // Directions spread evenly over the sphere; those nearer to the normal come first.
      const z = 1 - (2 * k + 1) / 60,
        r = Math.sqrt(1 - z * z),
        a = 2.39996 * k,
        side = new THREE.Vector3(r * Math.cos(a), z, r * Math.sin(a));
      if (side.dot(normal) > 0.1) sides.push(side);
    }
    sides.sort((a, b) => b.dot(normal) - a.dot(normal));
    for (const side of [...sides, sides[0]]) {
      this.frameBox(box.clone(), side);
      const hit = this.cast(0, 0);
      if (hit?.object === object && hit.point.distanceTo(p) < 0.02 * size) return;
    }
  }

  /// Moves the eye; offset: from the middle of the view.
  private moveEye(offset: THREE.Vector3): void {
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.redraw();
  }
  private get offset(): THREE.Vector3 {
    return this.camera.position.clone().sub(this.controls.target);
  }

  /// Turns the eye about the middle of the view, radians to the right and down.
  turn(right: number, down: number): void {
    const s = new THREE.Spherical().setFromVector3(this.offset);
    s.theta += right;
    s.phi = THREE.MathUtils.clamp(s.phi - down, 0.02, Math.PI - 0.02);
    this.moveEye(new THREE.Vector3().setFromSpherical(s));
  }
  /// Walks round the middle of the view by 15 degrees, as Q and E say.
  walk(key: string): void {
    this.turn((key === 'q' ? 1 : -1) * (Math.PI / 12), 0);
  }

  /// Brings the eye to that share of its distance.
  zoom(share: number): void {
    this.moveEye(this.offset.multiplyScalar(share));
  }

  pose(): number[] {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()].map((x) => Number(x.toFixed(4)));
  }
  setPose(p: number[]): void {
    if (p.length !== 6 || !p.every(Number.isFinite)) return;
    this.camera.position.set(p[0], p[1], p[2]);
    this.controls.target.set(p[3], p[4], p[5]);
    this.controls.update();
    this.redraw();
  }

  /// The position of a pointer on the view that it is over, -1 to 1 each way, y up.
  onCanvas(e: PointerEvent): THREE.Vector2 {
    const box = this.canvas.getBoundingClientRect();
    return new THREE.Vector2(
      (2 * ((e.clientX - box.left) % this.across)) / this.across - 1,
      1 - (2 * (e.clientY - box.top)) / box.height,
    );
  }
  /// The surface under a point of the canvas, -1 to 1 each way, y up. only: the one object that counts; -1: all count.
  cast(x: number, y: number, only = -1): Hit | null {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return this.objects.cast(this.raycaster, only);
  }

  /// The point on the ray that lies at the same depth from the camera as p.
  beside(x: number, y: number, p: THREE.Vector3): THREE.Vector3 {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.camera.getWorldDirection(new THREE.Vector3()), p);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3()) ?? p.clone();
  }

  /// The point of any object's surface, or of one object's, that appears nearest to a point of the canvas.
  nearestOnScreen(at: THREE.Vector2, only: number): { object: number; x: number; y: number } | null {
    let best: { object: number; x: number; y: number } | null = null,
      least = Infinity;
    const p = new THREE.Vector3();
    this.objects.eachVertex(only, 40, (object, v) => {
      p.copy(v).project(this.camera);
      const far = Math.hypot(p.x - at.x, p.y - at.y);
      if (far < least && Math.abs(p.z) <= 1) {
        least = far;
        best = { object, x: p.x, y: p.y };
      }
    });
    return best;
  }

  /// The share of a line, from a point that is seen, that stays in sight with a margin.
  inSight(from: THREE.Vector3, to: THREE.Vector3): number {
    const margin = 1 - 44 / Math.min(this.size.x, this.size.y),
      p = new THREE.Vector3();
    for (let share = 1; share > 0.15; share -= 0.05) {
      p.lerpVectors(from, to, share).project(this.camera);
      if (Math.abs(p.x) < margin && Math.abs(p.y) < margin) return share;
    }
    return 0.15;
  }

  /// The position at which p appears, in the left one of two views: pixels of the page from the stage's upper left.
  pixel(p: THREE.Vector3): THREE.Vector2 {
    const q = this.project(p);
    return q.set(0.5 * (q.x + 1) * this.across, 0.5 * (1 - q.y) * this.size.y);
  }
  /// The position at which p appears, -1 to 1 each way.
  project(p: THREE.Vector3): THREE.Vector2 {
    const q = p.clone().project(this.camera);
    return new THREE.Vector2(q.x, q.y);
  }

  groundAt(y: number): void {
    this.ground.position.y = y;
    this.redraw();
  }
  groundUnder(): void {
    this.groundAt(this.objects.low - 0.001);
  }
  castMesh(x: number, y: number, mesh: THREE.Mesh): THREE.Intersection | null {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return this.raycaster.intersectObject(mesh, false)[0] ?? null;
  }
  /// Makes a PNG of the view. width: pixels; 0: as many as the screen shows.
  async picture(width = 0): Promise<Blob | null> {
    if (!this.renderer) return null;
    const ratio = width > 0 ? width / this.size.x : this.finest(),
      picture = this.tiled(this.renderer, ratio);
    return new Promise<Blob | null>((resolve) => picture.toBlob(resolve, 'image/png'));
  }

  /// Draws the view with that many pixels to one of the page, in tiles: a graphics card limits the size of a picture.
  private tiled(renderer: THREE.WebGLRenderer, ratio: number): HTMLCanvasElement {
    const out = document.createElement('canvas'),
      context = out.getContext('2d')!;
    out.width = Math.round(ratio * this.size.x);
    out.height = Math.round(ratio * this.size.y);
    const views = this.split ? 2 : 1,
      wide = out.width / views,
      { height: high } = out;
    const draw = (view: number) => {
      for (let y = 0; y < high; y += TILE)
        for (let x = 0; x < wide; x += TILE) {
          const w = Math.min(TILE, Math.ceil(wide - x)),
            h = Math.min(TILE, high - y);
          this.camera.setViewOffset(wide, high, x, y, w, h);
          renderer.setDrawingBufferSize((w + 0.01) / ratio, (h + 0.01) / ratio, ratio);
          renderer.render(this.scene, this.camera);
          context.drawImage(this.canvas, Math.round(view * wide) + x, y);
        }
    };
    if (views === 2) this.inTurn(draw);
    else draw(0);
    this.camera.clearViewOffset();
    this.ratio = 0;
    this.fineness(this.finest());
    this.resize();
    return out;
  }
}
