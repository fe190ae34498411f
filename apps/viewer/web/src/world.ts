// The scene as three.js draws it. World: metres, y up.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { acceleratedRaycast, computeBoundsTree, disposeBoundsTree } from 'three-mesh-bvh';
import { colourField, partColour, type Rgb, type Scale } from './colours';
import { fetchBytes, type Frame, type ObjectFacts } from './net';

THREE.Mesh.prototype.raycast = acceleratedRaycast;
THREE.BufferGeometry.prototype.computeBoundsTree = computeBoundsTree;
THREE.BufferGeometry.prototype.disposeBoundsTree = disposeBoundsTree;

export interface Hit { object: number; part: number; triangle: number; point: THREE.Vector3; normal: THREE.Vector3; }

interface Shown {
  id: number; revision: number;
  surface: THREE.Mesh | null; superquadrics: THREE.Group; spheres: THREE.Group; partOf: Uint32Array; fields: Map<string, Float32Array>;
  indexed: THREE.BufferGeometry | null; samples: THREE.Points | null; shell: THREE.Mesh | null; hidden: Float32Array | null;
}

const HIDDEN: Rgb = [0.85, 0.05, 0.62];

/// Of the triangle whose nine numbers begin at i.
function areaOf(p: Float32Array, i: number): number {
  const a = [p[i + 3] - p[i], p[i + 4] - p[i + 1], p[i + 5] - p[i + 2]], b = [p[i + 6] - p[i], p[i + 7] - p[i + 1], p[i + 8] - p[i + 2]];
  return 0.5 * Math.hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

const ARROW = 0.03;  // m of arrow a newton

export class World {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.005, 20);
  readonly controls: OrbitControls;
  private scene = new THREE.Scene();
  private shown: (Shown | null)[] = [];
  private facts: ObjectFacts[] = [];
  private raycaster = new THREE.Raycaster();
  private tool: THREE.Mesh;
  private ball: THREE.SphereGeometry;
  private rim: THREE.Mesh;
  private toolVertices: Float32Array | null = null;
  readonly extra = new THREE.Group();  ///< the figure and its cloth
  private arrow = new THREE.Group();
  private shaft: THREE.Mesh;
  private head: THREE.Mesh;
  private marker: THREE.Mesh;
  private ground: THREE.GridHelper;
  private selected: { object: number; part: number } | null = null;
  colourBy = 'parts';
  surfaceAs: 'solid' | 'clear' | 'off' = 'solid';
  withSuperquadrics = false;
  withSpheres = false;
  withSamples = false;
  withOffset = false;  ///< the surface as eq. 12 moves it out
  withHidden = false;  ///< Q2: what its part's projection does not see first
  inHand = -1;         ///< the object that is held as the tool
  hiddenShare: string[] = [];
  hidden = false;  ///< recognition: nothing but the tool
  onScale: (scale: Scale | null) => void = () => {};
  onTrouble: (text: string) => void = () => {};
  private dirty = true;

  constructor(private canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
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
    const ball = this.ball = new THREE.SphereGeometry(1, 32, 24);
    // Black with a white rim: seen on every part's colour and on both stages.
    this.tool = new THREE.Mesh(ball, new THREE.MeshStandardMaterial({ color: 0x14181d, roughness: 0.35 }));
    const rim = this.rim = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: 0xffffff, side: THREE.BackSide }));
    rim.scale.setScalar(1.18);
    this.tool.add(rim);
    this.tool.scale.setScalar(0.006);
    this.tool.visible = false;
    this.scene.add(this.tool);
    const paint = new THREE.MeshBasicMaterial({ color: 0xd4145a, depthTest: false });
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.0016, 0.0016, 1, 12).translate(0, 0.5, 0), paint);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(0.0045, 0.011, 16).translate(0, 0.0055, 0), paint);
    this.arrow.add(this.shaft, this.head);
    this.arrow.visible = false;
    this.arrow.renderOrder = 10;
    this.shaft.renderOrder = this.head.renderOrder = 10;
    this.scene.add(this.arrow);
    this.marker = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: 0xd4145a, depthTest: false }));
    this.marker.renderOrder = 11;
    this.marker.scale.setScalar(0.0022);
    this.marker.visible = false;
    this.scene.add(this.marker);
    this.scene.add(this.extra);
    this.camera.position.set(0.25, 0.2, 0.6);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as HTMLElement);
    this.resize();
    const loop = () => {
      requestAnimationFrame(loop);
      this.controls.update();
      if (!this.dirty) return;
      this.dirty = false;
      this.renderer.render(this.scene, this.camera);
    };
    loop();
  }

  redraw(): void { this.dirty = true; }

  theme(): void {
    const style = getComputedStyle(document.documentElement);
    this.scene.background = new THREE.Color(style.getPropertyValue('--stage').trim());
    this.dirty = true;
  }

  private resize(): void {
    const box = (this.canvas.parentElement as HTMLElement).getBoundingClientRect();
    if (box.width < 2 || box.height < 2) return;
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  /// All objects, or one, in sight.
  frame(object = -1): void {
    const box = new THREE.Box3();
    this.facts.forEach((f, i) => {
      if (object >= 0 && i !== object) return;
      const c = new THREE.Vector3(...(f.place as [number, number, number])), half = new THREE.Vector3(...(f.half as [number, number, number]));
      box.expandByPoint(c.clone().sub(half)).expandByPoint(c.clone().add(half));
    });
    this.frameBox(box);
  }

  frameBox(box: THREE.Box3): void {
    if (box.isEmpty()) box.set(new THREE.Vector3(-0.1, -0.1, -0.1), new THREE.Vector3(0.1, 0.1, 0.1));
    const centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
    const tan = Math.tan((this.camera.fov * Math.PI) / 360);
    const distance = Math.max((0.66 * size.y) / tan, (0.54 * size.x) / (tan * this.camera.aspect)) + 0.4 * size.z + 0.02;
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(new THREE.Vector3(0.28, 0.3, 1).normalize(), distance);
    this.controls.update();
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

  async setScene(facts: ObjectFacts[]): Promise<void> {
    this.facts = facts;
    const before = this.shown;
    this.shown = facts.map((f) => before.find((s) => s && s.id === f.id && s.revision === f.revision) ?? null);
    for (const s of before) if (s && !this.shown.includes(s)) this.remove(s);
    const low = Math.min(0, ...facts.map((f) => f.place[1] - f.half[1]));
    this.ground.position.y = low - 0.001;
    await Promise.all(facts.map(async (f, i) => {
      if (this.shown[i]) return;
      const [mesh, superquadrics] = await Promise.all([fetchBytes(`/api/object/${i}/mesh`), fetchBytes(`/api/object/${i}/superquadrics`)]);
      if (this.facts !== facts) return;
      this.shown[i] = this.build(f, mesh, superquadrics);
    }));
    if (this.facts === facts) await this.paint();
  }

  private remove(s: Shown): void {
    if (s.surface) { this.scene.remove(s.surface); s.surface.geometry.dispose(); }
    for (const o of [s.samples, s.shell]) if (o) { this.scene.remove(o); o.geometry.dispose(); }
    s.indexed?.dispose();
    this.scene.remove(s.superquadrics, s.spheres);
    s.superquadrics.children.forEach((c) => (c as THREE.Mesh).geometry.dispose());
  }

  private build(f: ObjectFacts, meshData: ArrayBuffer, sqData: ArrayBuffer): Shown {
    const head = new Uint32Array(meshData, 0, 4);
    const [, nv, nt] = head;
    const positions = new Float32Array(meshData, 16, 3 * nv);
    const corners = new Uint32Array(meshData, 16 + 12 * nv, 3 * nt);
    const partOf = new Uint32Array(meshData, 16 + 12 * nv + 12 * nt, nt);
    let surface: THREE.Mesh | null = null, indexed: THREE.BufferGeometry | null = null;
    if (nt > 0) {
      indexed = new THREE.BufferGeometry();
      indexed.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      indexed.setIndex(new THREE.BufferAttribute(corners, 1));
      indexed.computeVertexNormals();
      const geometry = indexed.toNonIndexed();
      geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(9 * nt), 3));
      geometry.computeBoundsTree({ indirect: true } as never);
      surface = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.75, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1, side: f.solid ? THREE.FrontSide : THREE.DoubleSide }));
      this.scene.add(surface);
    }
    const superquadrics = new THREE.Group();
    const count = new Uint32Array(sqData, 4, 1)[0];
    let at = 8;
    for (let p = 0; p < count; ++p) {
      const [v, t] = new Uint32Array(sqData, at, 2);
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(sqData, at + 8, 3 * v), 3));
      g.setIndex(new THREE.BufferAttribute(new Uint32Array(sqData, at + 8 + 12 * v, 3 * t), 1));
      g.computeVertexNormals();
      at += 8 + 12 * v + 12 * t;
      const colour = new THREE.Color().setRGB(...partColour(p), THREE.SRGBColorSpace);
      const m = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ color: colour, transparent: true, opacity: 0.38, roughness: 0.5, depthWrite: false }));
      m.raycast = () => {};
      superquadrics.add(m);
    }
    this.scene.add(superquadrics);
    // Two levels, as section 4.1 has them: one about the object, one about each superquadric.
    const spheres = new THREE.Group(), ring = new THREE.EdgesGeometry(new THREE.SphereGeometry(1, 20, 14), 1);
    [f.sphere, ...f.parts.map((p) => p.sphere)].forEach((sphere, i) => {
      const colour = i === 0 ? new THREE.Color(0x888888) : new THREE.Color().setRGB(...partColour(i - 1), THREE.SRGBColorSpace);
      const line = new THREE.LineSegments(ring, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity: i === 0 ? 0.35 : 0.6 }));
      line.position.set(sphere[0], sphere[1], sphere[2]);
      line.scale.setScalar(sphere[3]);
      line.raycast = () => {};
      spheres.add(line);
    });
    this.scene.add(spheres);
    return { id: f.id, revision: f.revision, surface, superquadrics, spheres, partOf, fields: new Map(), indexed, samples: null, shell: null, hidden: null };
  }

  /// Colours and visibility as asked.
  async paint(): Promise<void> {
    let scale: Scale | null = null;
    const shares: string[] = [];
    const kind = this.colourBy;
    await Promise.all(this.shown.map(async (s, i) => {
      if (!s) return;
      s.superquadrics.visible = this.withSuperquadrics && !this.hidden;
      s.superquadrics.children.forEach((c, p) => {
        const on = !this.selected || this.selected.object !== i || this.selected.part < 0 || this.selected.part === p;
        ((c as THREE.Mesh).material as THREE.MeshStandardMaterial).opacity = on ? 0.42 : 0.16;
      });
      const there = !this.hidden && i !== this.inHand, baked = !this.facts[i].edited && this.facts[i].central;
      s.superquadrics.visible = s.superquadrics.visible && i !== this.inHand;
      s.spheres.visible = this.withSpheres && there;
      s.spheres.children.forEach((c, p) => { c.visible = !this.selected || this.selected.object !== i || this.selected.part < 0 || this.selected.part === p - 1; });
      if (!s.surface) return;
      if (baked) await this.overlays(s, i);
      if (s.samples) s.samples.visible = this.withSamples && there && baked;
      if (s.shell) s.shell.visible = this.withOffset && there && baked;
      const hidden = this.withHidden && baked ? s.hidden : null;
      if (hidden) {
        let all = 0, q2 = 0;
        const p = s.surface.geometry.getAttribute('position').array as Float32Array;
        for (let t = 0; t < hidden.length; ++t) {
          const a = areaOf(p, 9 * t);
          all += a;
          if (hidden[t] === 1) q2 += a;
        }
        shares[i] = `${this.facts[i].name} ${(100 * q2 / Math.max(all, 1e-12)).toFixed(1)} %`;
      }
      s.surface.visible = this.surfaceAs !== 'off' && there;
      const material = s.surface.material as THREE.MeshStandardMaterial;
      material.transparent = this.surfaceAs === 'clear';
      material.opacity = this.surfaceAs === 'clear' ? 0.35 : 1;
      material.needsUpdate = true;
      let colours: (t: number) => Rgb;
      if (kind === 'parts') {
        colours = (t) => {
          const part = s.partOf[t], c = partColour(part);
          const other = this.selected && this.selected.object === i && this.selected.part >= 0 && this.selected.part !== part;
          return other ? (c.map((x) => 0.45 * x + 0.4) as Rgb) : c;
        };
      } else {
        let values = s.fields.get(kind);
        if (!values) {
          try {
            const data = await fetchBytes(`/api/object/${i}/field/${kind}`);
            values = new Float32Array(data, 8);
          } catch (e) { this.onTrouble(String(e)); return; }
          s.fields.set(kind, values);
        }
        const painted = colourField(kind, values);
        scale = painted;
        colours = (t) => painted.colours[t];
      }
      if (this.colourBy !== kind) return;
      const attribute = s.surface.geometry.getAttribute('color') as THREE.BufferAttribute;
      const array = attribute.array as Float32Array;
      const linear = new THREE.Color();
      for (let t = 0; t < s.partOf.length; ++t) {
        linear.setRGB(...(hidden && hidden[t] === 1 ? HIDDEN : colours(t)), THREE.SRGBColorSpace);
        for (let k = 0; k < 3; ++k) { array[9 * t + 3 * k] = linear.r; array[9 * t + 3 * k + 1] = linear.g; array[9 * t + 3 * k + 2] = linear.b; }
      }
      attribute.needsUpdate = true;
    }));
    this.ground.visible = true;
    this.hiddenShare = shares.filter((x) => x);
    if (this.colourBy === kind) this.onScale(scale);
    this.dirty = true;
  }

  /// What the toggles ask for, fetched once.
  private async overlays(s: Shown, i: number): Promise<void> {
    try {
      if (this.withSamples && !s.samples) {
        const data = await fetchBytes(`/api/object/${i}/samples`), n = new Uint32Array(data, 4, 1)[0];
        const g = new THREE.BufferGeometry(), part = new Uint32Array(data, 8 + 12 * n, n), colours = new Float32Array(3 * n), c = new THREE.Color();
        for (let k = 0; k < n; ++k) { c.setRGB(...(partColour(part[k]).map((x) => 0.45 * x) as Rgb), THREE.SRGBColorSpace); colours.set([c.r, c.g, c.b], 3 * k); }
        g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(data, 8, 3 * n), 3));
        g.setAttribute('color', new THREE.BufferAttribute(colours, 3));
        if (!s.samples) {
          s.samples = new THREE.Points(g, new THREE.PointsMaterial({ size: 2.4 * this.renderer.getPixelRatio(), sizeAttenuation: false, vertexColors: true }));
          s.samples.renderOrder = 2;
          s.samples.raycast = () => {};
          this.scene.add(s.samples);
        }
      }
      if (this.withOffset && !s.shell && s.indexed) {
        const out = new Float32Array(await fetchBytes(`/api/object/${i}/offset`), 8);
        const from = s.indexed.getAttribute('position').array, normal = s.indexed.getAttribute('normal').array, to = new Float32Array(from.length);
        for (let k = 0; k < to.length; ++k) to[k] = from[k] + normal[k] * (out[Math.floor(k / 3)] + 1e-5);
        const g = new THREE.BufferGeometry();
        g.setAttribute('position', new THREE.BufferAttribute(to, 3));
        g.setIndex(s.indexed.getIndex());
        g.computeVertexNormals();
        if (!s.shell) {
          s.shell = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ color: 0x0b9dc4, transparent: true, opacity: 0.55, roughness: 0.5 }));
          s.shell.raycast = () => {};
          this.scene.add(s.shell);
        }
      }
      if (this.withHidden && !s.hidden) s.hidden = new Float32Array(await fetchBytes(`/api/object/${i}/hidden`), 8);
    } catch (e) { this.onTrouble(String(e)); }
  }

  /// For tests and legends: samples shown, share of vertices that the offset moves, triangles hidden.
  overlay(object: number): { samples: number; moved: number; hidden: number; spheres: boolean } {
    const s = this.shown[object];
    let moved = 0;
    if (s?.shell && s.indexed) {
      const a = s.indexed.getAttribute('position').array, b = s.shell.geometry.getAttribute('position').array;
      for (let k = 0; k < a.length; k += 3) if (Math.hypot(a[k] - b[k], a[k + 1] - b[k + 1], a[k + 2] - b[k + 2]) > 1e-4) ++moved;
    }
    return {
      samples: s?.samples?.visible ? s.samples.geometry.getAttribute('position').count : 0,
      moved: s?.shell?.visible ? moved : 0, hidden: s?.hidden && this.withHidden ? s.hidden.filter((x) => x === 1).length : 0,
      spheres: s?.spheres.visible ?? false,
    };
  }

  /// The surface nearest to a place, as a hit.
  nearest(object: number, p: THREE.Vector3): Hit | null {
    const s = this.shown[object];
    const tree = s?.surface?.geometry.boundsTree;
    const found = tree?.closestPointToPoint(p);
    if (!s?.surface || !found) return null;
    const q = s.surface.geometry.getAttribute('position').array as Float32Array, t = found.faceIndex;
    const v = (k: number) => new THREE.Vector3(q[9 * t + 3 * k], q[9 * t + 3 * k + 1], q[9 * t + 3 * k + 2]);
    const normal = v(1).sub(v(0)).cross(v(2).sub(v(0))).normalize();
    return { object, part: s.partOf[t], triangle: t, point: found.point.clone(), normal };
  }

  select(object: number, part: number): void {
    this.selected = object < 0 ? null : { object, part };
    void this.paint();
  }

  /// What lies under a place of the canvas, -1 to 1 each way, y up. only: one object.
  cast(x: number, y: number, only = -1): Hit | null {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    let best: Hit | null = null, distance = Infinity;
    this.shown.forEach((s, i) => {
      if (!s?.surface || (only >= 0 && i !== only) || i === this.inHand) return;
      const visible = s.surface.visible;
      s.surface.visible = true;
      const [hit] = this.raycaster.intersectObject(s.surface, false);
      s.surface.visible = visible;
      if (!hit || hit.distance >= distance || hit.faceIndex == null) return;
      distance = hit.distance;
      best = { object: i, part: s.partOf[hit.faceIndex], triangle: hit.faceIndex, point: hit.point.clone(), normal: hit.face!.normal.clone() };
    });
    return best;
  }

  /// The place on the ray that lies at the same depth from the camera as p.
  beside(x: number, y: number, p: THREE.Vector3): THREE.Vector3 {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.camera.getWorldDirection(new THREE.Vector3()), p);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3()) ?? p.clone();
  }

  /// Where p appears, -1 to 1 each way.
  project(p: THREE.Vector3): THREE.Vector2 { const q = p.clone().project(this.camera); return new THREE.Vector2(q.x, q.y); }

  private radius = 0.006;
  toolRadius(r: number): void {
    this.radius = r;
    if (!this.toolVertices) this.tool.scale.setScalar(r);
    this.dirty = true;
  }

  /// What is held: null a ball, else triangles about the tool's centre.
  toolShape(positions: Float32Array | null, corners: Uint32Array | null): void {
    if (this.tool.geometry !== this.ball) this.tool.geometry.dispose();
    this.toolVertices = positions;
    const material = this.tool.material as THREE.MeshStandardMaterial;
    this.rim.visible = !positions;
    material.transparent = !!positions;
    material.opacity = positions ? 0.82 : 1;
    material.color.set(positions ? 0x39424d : 0x14181d);
    material.needsUpdate = true;
    if (positions && corners) {
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      g.setIndex(new THREE.BufferAttribute(corners, 1));
      g.computeVertexNormals();
      this.tool.geometry = g;
      this.tool.scale.setScalar(1);
    } else {
      this.tool.geometry = this.ball;
      this.tool.scale.setScalar(this.radius);
    }
    this.dirty = true;
  }

  /// How far a mesh spreads about its centre, so that it is taken up clear of what lies beside; 0 for the ball.
  toolSpan(): number {
    const p = this.toolVertices;
    let most = 0;
    if (p) for (let k = 0; k < p.length; k += 3) most = Math.max(most, Math.hypot(p[k], p[k + 1], p[k + 2]));
    return most;
  }

  /// Of the tool about its centre: the place that touches a surface with this normal first.
  toolTip(normal: THREE.Vector3): THREE.Vector3 {
    const p = this.toolVertices;
    if (!p) return normal.clone().multiplyScalar(-this.radius);
    let least = Infinity, best = 0;
    for (let k = 0; k < p.length; k += 3) {
      const d = p[k] * normal.x + p[k + 1] * normal.y + p[k + 2] * normal.z;
      if (d < least) { least = d; best = k; }
    }
    return new THREE.Vector3(p[best], p[best + 1], p[best + 2]);
  }

  showTool(frame: Frame | null): void {
    this.tool.visible = frame !== null;
    this.arrow.visible = false;
    this.dirty = true;
    if (!frame) return;
    this.tool.position.set(frame.tool[0], frame.tool[1], frame.tool[2]);
    const m = frame.turn;
    this.tool.quaternion.setFromRotationMatrix(new THREE.Matrix4().set(m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, 0, 0, 0, 1));
    this.showArrow(this.tool.position, new THREE.Vector3(frame.force[0], frame.force[1], frame.force[2]));
  }

  /// An arrow of force from a place; thick: times the usual thickness, for larger scenes. Null: none.
  showArrow(at: THREE.Vector3 | null, force = new THREE.Vector3(), thick = 1): void {
    const size = force.length(), length = ARROW * size;
    this.arrow.visible = at !== null && size >= 0.02;
    this.dirty = true;
    if (!at || !this.arrow.visible) return;
    this.arrow.position.copy(at);
    this.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.clone().divideScalar(size));
    this.shaft.scale.set(thick, length, thick);
    this.head.scale.setScalar(thick);
    this.head.position.y = length;
  }

  /// For tests: where the arrow is and points.
  arrowNow(): { visible: boolean; direction: number[]; length: number } {
    const d = new THREE.Vector3(0, 1, 0).applyQuaternion(this.arrow.quaternion);
    return { visible: this.arrow.visible, direction: d.toArray(), length: this.shaft.scale.y };
  }

  mark(p: THREE.Vector3 | null): void {
    this.marker.visible = p !== null;
    if (p) this.marker.position.copy(p);
    this.dirty = true;
  }

  fieldAt(object: number, kind: string, triangle: number): number | undefined { return this.shown[object]?.fields.get(kind)?.[triangle]; }
  groundAt(y: number): void { this.ground.position.y = y; this.dirty = true; }
  groundUnder(): void { this.groundAt(Math.min(0, ...this.facts.map((f) => f.place[1] - f.half[1])) - 0.001); }
  castMesh(x: number, y: number, mesh: THREE.Mesh): THREE.Vector3 | null {
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return this.raycaster.intersectObject(mesh, false)[0]?.point ?? null;
  }
  ready(): boolean { return this.shown.length > 0 && this.shown.every((s) => s !== null); }

  picture(): Promise<Blob | null> {
    this.renderer.render(this.scene, this.camera);
    return new Promise((resolve) => this.canvas.toBlob(resolve, 'image/png'));
  }
}
