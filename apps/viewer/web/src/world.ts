// The scene: camera, light, the loop that draws, what lies under a point of the canvas. World: metres, y up.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { meter } from './meter';
import type { ObjectFacts } from './net';
import { fullRatio, Objects, type Hit } from './objects';
import { Pace } from './pace';
import { GroundShadow } from './shadow';
import { Tool } from './tool';
import { Traces } from './traces';

function rendererOf(canvas: HTMLCanvasElement): THREE.WebGLRenderer | null {
  try {
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    renderer.localClippingEnabled = true;
    renderer.debug.checkShaderErrors = false;  // to ask would wait for the graphics card
    return renderer;
  } catch { return null; }
}

export class World {
  readonly renderer: THREE.WebGLRenderer | null;  ///< null: this browser has no WebGL; all but the picture goes on
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.005, 20);
  readonly controls: OrbitControls;
  private scene = new THREE.Scene();
  readonly objects: Objects;
  readonly tool: Tool;
  readonly traces: Traces;
  readonly extra = new THREE.Group();  ///< the figure and its cloth
  private raycaster = new THREE.Raycaster();
  private ground: THREE.GridHelper;
  private shadow: GroundShadow | null;
  onFrame: (now: number) => void = () => {};  ///< before each draw
  readonly pace = new Pace();
  private share = 1;  ///< of the screen's pixels along each side that were drawn last
  private framed: { box: THREE.Box3; at: THREE.Vector3 } | null = null;  ///< what was brought into sight, and from where
  private dirty = true;

  constructor(private canvas: HTMLCanvasElement) {
    this.renderer = rendererOf(canvas);
    this.renderer?.setPixelRatio(fullRatio());
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.15;
    this.controls.addEventListener('change', () => { this.dirty = true; });
    this.raycaster.firstHitOnly = true;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.9));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.5, 1, 0.8);
    this.camera.add(sun);
    this.scene.add(this.camera);
    this.ground = new THREE.GridHelper(2, 40, 0x888888, 0x888888);
    (this.ground.material as THREE.Material).transparent = true;
    (this.ground.material as THREE.Material).opacity = 0.22;
    this.scene.add(this.ground);
    this.shadow = this.renderer && new GroundShadow(this.scene, this.renderer);
    this.objects = new Objects(this.scene, () => this.redraw());
    this.tool = new Tool(this.scene, () => this.redraw());
    this.traces = new Traces(this.scene, () => this.redraw());
    this.scene.add(this.extra);
    this.camera.position.set(0.25, 0.2, 0.6);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as HTMLElement);
    this.resize();
    const loop = (now: number) => {
      requestAnimationFrame(loop);
      meter.frame(now);
      this.onFrame(now);
      meter.spend('draw', () => {
        this.controls.update();
        if (!this.dirty) {
          if (!this.pace.still(now)) return;
          this.pace.rested();
          if (this.share === 1) return;
          this.fineness(1);
        } else this.fineness(this.pace.next(now));
        this.dirty = false;
        if (!this.renderer) return;
        this.renderer.render(this.scene, this.camera);
        meter.drawn(this.renderer.info.render.calls, this.renderer.info.render.triangles);
      });
    };
    requestAnimationFrame(loop);
  }

  redraw(): void { this.dirty = true; }

  private fineness(share: number): void {
    if (share === this.share) return;
    this.share = share;
    this.renderer?.setPixelRatio(share * fullRatio());  // sets the size as well
  }

  theme(): void {
    const style = getComputedStyle(document.documentElement);
    this.scene.background = new THREE.Color(style.getPropertyValue('--stage').trim());
    this.dirty = true;
  }

  private resize(): void {
    const box = (this.canvas.parentElement as HTMLElement).getBoundingClientRect();
    if (box.width < 2 || box.height < 2) return;
    this.renderer?.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    // Nobody has turned it since: in sight it stays.
    if (this.framed && this.framed.at.distanceTo(this.camera.position) < 1e-6) this.frameBox(this.framed.box);
    this.dirty = true;
  }

  /// Draws these objects, over the ground.
  async setScene(facts: ObjectFacts[]): Promise<void> {
    const drawn = this.objects.set(facts);
    this.groundUnder();
    await drawn;
    this.shade();
  }

  /// The shadow on the ground, anew: of the objects that are drawn.
  shade(): void {
    this.shadow?.draw(this.objects.surfaces(), this.objects.box(), this.objects.low - 0.001);
    this.dirty = true;
  }

  /// All objects, or one, in sight.
  frame(object = -1): void { this.frameBox(this.objects.box(object)); }

  frameBox(box: THREE.Box3): void {
    if (box.isEmpty()) box.set(new THREE.Vector3(-0.1, -0.1, -0.1), new THREE.Vector3(0.1, 0.1, 0.1));
    const centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
    const from = new THREE.Vector3(0.28, 0.3, 1).normalize(), corner = new THREE.Vector3();
    this.controls.target.copy(centre);
    // As near as all corners are in sight, with a margin.
    for (let distance = 0.5 * size.length() + 0.02, k = 0; k < 40; ++k, distance *= 1.06) {
      this.camera.position.copy(centre).addScaledVector(from, distance);
      this.camera.lookAt(centre);
      this.camera.updateMatrixWorld();
      let most = 0;
      for (let c = 0; c < 8; ++c) {
        corner.set(c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y, c & 4 ? box.max.z : box.min.z).project(this.camera);
        most = Math.max(most, Math.abs(corner.x), Math.abs(corner.y), Math.abs(corner.z) > 1 ? 2 : 0);
      }
      if (most < 0.93) break;
    }
    this.controls.update();
    this.framed = { box: box.clone(), at: this.camera.position.clone() };
    this.camera.updateMatrixWorld();
    this.dirty = true;
  }

  readonly axes = new THREE.AxesHelper(0.1);
  /// x red, y green, z blue, 10 cm each, at the lower corner of what is drawn.
  showAxes(yes: boolean): void {
    const box = this.objects.box();
    this.axes.position.set(box.min.x, this.objects.low, box.max.z);
    if (yes) this.scene.add(this.axes); else this.scene.remove(this.axes);
    this.dirty = true;
  }

  /// From a direction, as far away as it is.
  look(from: THREE.Vector3): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.position.copy(this.controls.target).addScaledVector(from.clone().normalize(), distance);
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.dirty = true;
  }

  /// About the middle of the view, radians to the right and down.
  turn(right: number, down: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target), s = new THREE.Spherical().setFromVector3(offset);
    s.theta += right;
    s.phi = Math.min(Math.max(s.phi - down, 0.02), Math.PI - 0.02);
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(s));
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.dirty = true;
  }

  /// Brings the eye to that share of its distance.
  zoom(share: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(share).add(this.controls.target);
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.dirty = true;
  }

  pose(): number[] { return [...this.camera.position.toArray(), ...this.controls.target.toArray()].map((x) => Number(x.toFixed(4))); }
  setPose(p: number[]): void {
    if (p.length !== 6 || !p.every(Number.isFinite)) return;
    this.camera.position.set(p[0], p[1], p[2]);
    this.controls.target.set(p[3], p[4], p[5]);
    this.controls.update();
    this.dirty = true;
  }

  /// Where a pointer is on the canvas, -1 to 1 each way, y up.
  onCanvas(e: PointerEvent): THREE.Vector2 {
    const box = this.canvas.getBoundingClientRect();
    return new THREE.Vector2((2 * (e.clientX - box.left)) / box.width - 1, 1 - (2 * (e.clientY - box.top)) / box.height);
  }
  /// What lies under a point of the canvas, -1 to 1 each way, y up. only: one object.
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
    let best: { object: number; x: number; y: number } | null = null, least = Infinity;
    const p = new THREE.Vector3();
    this.objects.eachVertex(only, 40, (object, v) => {
      p.copy(v).project(this.camera);
      const far = Math.hypot(p.x - at.x, p.y - at.y);
      if (far < least && Math.abs(p.z) <= 1) { least = far; best = { object, x: p.x, y: p.y }; }
    });
    return best;
  }

  /// Where p appears, -1 to 1 each way.
  project(p: THREE.Vector3): THREE.Vector2 { const q = p.clone().project(this.camera); return new THREE.Vector2(q.x, q.y); }

  groundAt(y: number): void { this.ground.position.y = y; this.dirty = true; }
  groundUnder(): void { this.groundAt(this.objects.low - 0.001); }
  castMesh(x: number, y: number, mesh: THREE.Mesh): THREE.Intersection | null {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return this.raycaster.intersectObject(mesh, false)[0] ?? null;
  }
  /// width: pixels; 0: as many as the screen shows.
  async picture(width = 0): Promise<Blob | null> {
    if (!this.renderer) return null;
    this.fineness(1);
    const box = (this.canvas.parentElement as HTMLElement).getBoundingClientRect();
    if (width > 0) this.renderer.setPixelRatio(width / box.width);
    this.renderer.render(this.scene, this.camera);
    const blob = await new Promise<Blob | null>((resolve) => this.canvas.toBlob(resolve, 'image/png'));
    this.renderer.setPixelRatio(fullRatio());
    this.dirty = true;
    return blob;
  }
}
