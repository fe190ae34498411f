// The objects as three.js draws them: surfaces, superquadrics, spheres and overlays, coloured by part or by field.
import * as THREE from 'three';
import { acceleratedRaycast, computeBoundsTree, disposeBoundsTree } from 'three-mesh-bvh';
import { colourField, distinctColours, MISS, partColour, type Range, type Rgb, type Scale } from './colours';
import { meter } from './meter';
import type { ObjectFacts } from './messages';
import { fetchBytes } from './net';
import { linear, Surface } from './surface';

THREE.Mesh.prototype.raycast = acceleratedRaycast;
THREE.BufferGeometry.prototype.computeBoundsTree = computeBoundsTree;
THREE.BufferGeometry.prototype.disposeBoundsTree = disposeBoundsTree;

export interface Hit { object: number; part: number; triangle: number; point: THREE.Vector3; normal: THREE.Vector3; }

interface Shown {
  id: number; revision: number;
  surface: Surface | null; superquadrics: Pieces<THREE.Mesh>; spheres: Pieces<THREE.LineSegments>; fields: Map<string, Float32Array>;
  colours: Rgb[]; samples: THREE.Points | null; shell: THREE.Mesh | null; hidden: Float32Array | null; painted: string;
}

/// One thing a part, all drawn in one call: colours are of vertices, piece p has those from first[p] to first[p + 1].
interface Pieces<T extends THREE.Mesh | THREE.LineSegments> { all: T; first: number[]; }

/// How much of each piece is seen, 0 to 1.
function setOpacity(pieces: Pieces<THREE.Mesh | THREE.LineSegments>, of: (piece: number) => number): void {
  const colour = pieces.all.geometry.getAttribute('color') as THREE.BufferAttribute, array = colour.array as Float32Array;
  let changed = false;
  for (let p = 0; p + 1 < pieces.first.length; ++p) {
    const opacity = Math.fround(of(p)), from = pieces.first[p];
    if (from === pieces.first[p + 1] || array[4 * from + 3] === opacity) continue;
    for (let v = from; v < pieces.first[p + 1]; ++v) array[4 * v + 3] = opacity;
    changed = true;
  }
  if (changed) colour.needsUpdate = true;
}

const HIDDEN: Rgb = [0.85, 0.05, 0.62];

export const fullRatio = (): number => Math.min(devicePixelRatio, 2);

export class Objects {
  colourBy = 'parts';
  beside: 'none' | 'layer-2' | 'twin' = 'none';  ///< what a second view shows beside the first
  range: Range = null;  ///< where the field's colours end; null: where its values do
  surfaceAs: 'solid' | 'clear' | 'wire' | 'off' = 'solid';
  withSuperquadrics = false;
  withSpheres = false;
  withSamples = false;
  withOffset = false;  ///< the surface as eq. 12 moves it out
  withHidden = false;  ///< Q2: what its part's projection does not see first
  inHand = -1;         ///< the object that is held as the tool
  hiddenShare: string[] = [];
  focus = -1;          ///< the object that is looked at: the others are pale; -1: all alike
  hidden = false;  ///< recognition: nothing but the tool
  dims = true;     ///< parts beside the selected one are pale
  onScale: (scale: Scale | null) => void = () => {};
  onWait: (kind: string, done: number, of: number) => void = () => {};  ///< fields that the program computes
  onTrouble: (what: unknown) => void = () => {};
  private facts: ObjectFacts[] = [];
  private shown: (Shown | null)[] = [];
  private selected: { object: number; part: number } | null = null;

  constructor(private scene: THREE.Scene, private redraw: () => void) {}

  /// Of all objects, or of one: the world's box, m.
  box(object = -1): THREE.Box3 {
    const box = new THREE.Box3();
    this.facts.forEach((f, i) => {
      if (object >= 0 && i !== object) return;
      const c = new THREE.Vector3(...(f.position as [number, number, number])), half = new THREE.Vector3(...(f.half as [number, number, number]));
      box.expandByPoint(c.clone().sub(half)).expandByPoint(c.clone().add(half));
    });
    return box;
  }

  get count(): number { return this.facts.length; }
  /// m, the lowest point of any, at most 0.
  get low(): number { return Math.min(0, ...this.facts.map((f) => f.position[1] - f.half[1])); }

  /// Fetches what is new, removes what is gone.
  async set(facts: ObjectFacts[]): Promise<void> {
    this.facts = facts;
    const before = this.shown;
    this.shown = facts.map((f) => before.find((s) => s && s.id === f.id && s.revision === f.revision) ?? null);
    for (const s of before) if (s && !this.shown.includes(s)) this.remove(s);
    for (const s of this.shown) s?.fields.delete('difference');  // it may have a twin now, or another
    await Promise.all(facts.map(async (f, i) => {
      if (this.shown[i]) return;
      const [mesh, superquadrics] = await Promise.all([fetchBytes(`/api/object/${i}/mesh`), fetchBytes(`/api/object/${i}/superquadrics`)]);
      if (this.facts !== facts) return;
      this.shown[i] = this.build(f, mesh, superquadrics);
    }));
    if (this.facts === facts) await this.paint();
  }

  private remove(s: Shown): void {
    for (const key of [...this.left]) if (key.startsWith(`${s.id}/`)) this.left.delete(key);
    this.onLeft(this.left.size);
    if (s.surface) { this.scene.remove(s.surface.mesh); s.surface.dispose(); }
    for (const o of [s.samples, s.shell]) if (o) { this.scene.remove(o); o.geometry.dispose(); }
    for (const { all } of [s.superquadrics, s.spheres]) { this.scene.remove(all); all.geometry.dispose(); }
  }

  private build(f: ObjectFacts, meshData: ArrayBuffer, sqData: ArrayBuffer): Shown {
    const head = new Uint32Array(meshData, 0, 4);
    const [, nv, nt] = head;
    const positions = new Float32Array(meshData, 16, 3 * nv);
    const corners = new Uint32Array(meshData, 16 + 12 * nv, 3 * nt);
    const partOf = new Uint32Array(meshData, 16 + 12 * nv + 12 * nt, nt);
    const surface = nt > 0 ? new Surface(positions, corners, partOf, f.solid) : null;
    if (surface) { this.scene.add(surface.mesh); void surface.shade(this.redraw); }
    const own = distinctColours(f.parts.map((p) => p.neighbours)), superquadrics = this.buildSuperquadrics(sqData, own), spheres = this.buildSpheres(f, own);
    this.scene.add(superquadrics.all, spheres.all);
    return { id: f.id, revision: f.revision, surface, superquadrics, spheres, fields: new Map(), colours: own, samples: null, shell: null, hidden: null, painted: '' };
  }

  private buildSuperquadrics(data: ArrayBuffer, own: Rgb[]): Pieces<THREE.Mesh> {
    const count = new Uint32Array(data, 4, 1)[0], sizes: [number, number, number][] = [], first = [0];
    let at = 8, corners = 0;
    for (let p = 0; p < count; ++p) {
      const [v, t] = new Uint32Array(data, at, 2);
      sizes.push([at, v, t]);
      first.push(first[p] + v);
      corners += 3 * t;
      at += 8 + 12 * v + 12 * t;
    }
    const positions = new Float32Array(3 * first[count]), colours = new Float32Array(4 * first[count]), index = new Uint32Array(corners);
    let next = 0;
    sizes.forEach(([from, v, t], p) => {
      positions.set(new Float32Array(data, from + 8, 3 * v), 3 * first[p]);
      for (const corner of new Uint32Array(data, from + 8 + 12 * v, 3 * t)) index[next++] = corner + first[p];
      const c = linear(own[p]);
      for (let k = first[p]; k < first[p + 1]; ++k) colours.set([c.r, c.g, c.b, 1], 4 * k);
    });
    const g = new THREE.BufferGeometry();
    g.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    g.setAttribute('color', new THREE.BufferAttribute(colours, 4));
    g.setIndex(new THREE.BufferAttribute(index, 1));
    g.computeVertexNormals();
    const all = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ vertexColors: true, transparent: true, roughness: 0.5, depthWrite: false }));
    all.raycast = () => {};
    return { all, first };
  }

  /// Two levels, as section 4.1 has them: piece 0 about the object, the others about each superquadric.
  private buildSpheres(f: ObjectFacts, own: Rgb[]): Pieces<THREE.LineSegments> {
    const ring = new THREE.EdgesGeometry(new THREE.SphereGeometry(1, 20, 14), 1).getAttribute('position'), n = ring.count;
    const all = [f.sphere, ...f.parts.map((p) => p.sphere)], first = all.map((_, i) => i * n).concat(all.length * n);
    const positions = new Float32Array(3 * n * all.length), colours = new Float32Array(4 * n * all.length);
    all.forEach(([x, y, z, r], i) => {
      const c = i === 0 ? new THREE.Color(0x888888) : linear(own[i - 1]);
      for (let k = 0; k < n; ++k) {
        positions.set([x + r * ring.getX(k), y + r * ring.getY(k), z + r * ring.getZ(k)], 3 * (i * n + k));
        colours.set([c.r, c.g, c.b, 1], 4 * (i * n + k));
      }
    });
    const g = new THREE.BufferGeometry();
    g.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    g.setAttribute('color', new THREE.BufferAttribute(colours, 4));
    const lines = new THREE.LineSegments(g, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
    lines.raycast = () => {};
    return { all: lines, first };
  }

  /// Colours and visibility as asked.
  async paint(): Promise<void> {
    const shares: string[] = [], kind = this.colourBy, other = kind === 'error' && this.beside === 'layer-2';
    if (kind !== 'parts') await this.fields(kind);
    if (other) await this.fields('error-2');
    if (this.colourBy !== kind) return;
    // One scale for all objects, so that the legend is true of each.
    const values = this.shown.map((s) => (kind === 'parts' ? undefined : s?.fields.get(kind)));
    const known = values.filter((v) => v !== undefined), joined = new Float32Array(known.reduce((n, v) => n + v.length, 0));
    known.reduce((at, v) => { joined.set(v, at); return at + v.length; }, 0);
    const scale = joined.length ? colourField(kind, joined, this.range) : null;
    await Promise.all(this.shown.map(async (s, i) => {
      if (!s) return;
      const there = !this.hidden && i !== this.inHand, baked = !this.facts[i].edited;
      const chosen = this.dims && this.selected?.object === i ? this.selected.part : -1;
      s.superquadrics.all.visible = this.withSuperquadrics && there;
      setOpacity(s.superquadrics, (p) => (chosen < 0 || chosen === p ? 0.42 : 0.16));
      s.spheres.all.visible = this.withSpheres && there;
      setOpacity(s.spheres, (p) => (chosen >= 0 && chosen !== p - 1 ? 0 : p === 0 ? 0.35 : 0.6));
      if (!s.surface) return;
      if (baked) await this.overlays(s, i);
      if (this.colourBy !== kind) return;
      if (s.samples) s.samples.visible = this.withSamples && there && baked;
      if (s.shell) s.shell.visible = this.withOffset && there && baked;
      const hidden = this.withHidden && baked ? s.hidden : null;
      if (hidden) shares[i] = `${this.facts[i].name} ${(100 * s.surface.shareOf(hidden)).toFixed(1)} %`;
      s.surface.mesh.visible = this.isSeen(i);
      const material = s.surface.mesh.material, clear = this.surfaceAs === 'clear';
      if (material.transparent !== clear) material.needsUpdate = true;
      material.transparent = clear;
      material.wireframe = this.surfaceAs === 'wire';
      material.opacity = clear ? 0.35 : 1;
      const field = scale && values[i] ? { values: values[i], scale } : null;
      // What decides the colours; the same is not painted twice.
      const pale = this.focus >= 0 && this.focus !== i && !(this.beside === 'twin' && this.pair()?.includes(i));
      const key = `${kind}${field ? '' : '!'}|${scale?.key ?? ''}|${chosen}|${hidden ? 1 : 0}|${pale ? 1 : 0}`;
      if (s.painted === `${key}|${other}`) return;
      s.painted = `${key}|${other}`;
      const parts = s.colours.map((c, p) => linear(pale ? (c.map((x) => 0.28 * x + 0.5) as Rgb) : chosen >= 0 && chosen !== p ? (c.map((x) => 0.45 * x + 0.4) as Rgb) : c));
      meter.spend('colours', () => s.surface!.colour({ parts, field, marks: hidden, mark: linear(HIDDEN) }));
      const second = other ? s.fields.get('error-2') : undefined;
      s.surface.second(scale && second ? { parts, field: { values: second, scale }, marks: hidden, mark: linear(HIDDEN) } : null);
    }));
    this.hiddenShare = shares.filter((x) => x);
    if (this.colourBy === kind) this.onScale(scale);
    this.redraw();
  }

  /// The program needs seconds for some: each arrives as it is ready, and onWait tells how many have.
  private async fields(kind: string): Promise<void> {
    const missing = this.shown.flatMap((s, i) => (s?.surface && !s.fields.has(kind) && (kind !== 'difference' || this.facts[i].twin !== null) ? [[s, i] as const] : []));
    let done = 0;
    if (missing.length) this.onWait(kind, 0, missing.length);
    await Promise.all(missing.map(async ([s, i]) => {
      try { s.fields.set(kind, new Float32Array(await fetchBytes(`/api/object/${i}/field/${kind}`), 8)); } catch (e) { this.onTrouble(e); }
      if (this.colourBy === kind || kind === 'error-2') this.onWait(kind, ++done, missing.length);
    }));
  }

  /// What the toggles ask for, fetched once.
  private async overlays(s: Shown, i: number): Promise<void> {
    try {
      if (this.withSamples && !s.samples) {
        const data = await fetchBytes(`/api/object/${i}/samples`), n = new Uint32Array(data, 4, 1)[0];
        const g = new THREE.BufferGeometry(), part = new Uint32Array(data, 8 + 12 * n, n), colours = new Float32Array(3 * n);
        for (let k = 0; k < n; ++k) { const c = linear(s.colours[part[k]], 0.45); colours.set([c.r, c.g, c.b], 3 * k); }
        g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(data, 8, 3 * n), 3));
        g.setAttribute('color', new THREE.BufferAttribute(colours, 3));
        if (!s.samples) {
          s.samples = new THREE.Points(g, new THREE.PointsMaterial({ size: 2.4, sizeAttenuation: false, vertexColors: true }));
          s.samples.renderOrder = 2;
          s.samples.raycast = () => {};
          this.scene.add(s.samples);
        }
      }
      if (this.withOffset && !s.shell && s.surface) {
        const out = new Float32Array(await fetchBytes(`/api/object/${i}/offset`), 8);
        const { whole } = s.surface, from = whole.getAttribute('position').array, normal = whole.getAttribute('normal').array, to = new Float32Array(from.length);
        for (let k = 0; k < to.length; ++k) to[k] = from[k] + normal[k] * (out[Math.floor(k / 3)] + 1e-5);
        const g = new THREE.BufferGeometry();
        g.setAttribute('position', new THREE.BufferAttribute(to, 3));
        g.setIndex(whole.getIndex());
        g.computeVertexNormals();
        if (!s.shell) {
          s.shell = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ color: 0x0b9dc4, transparent: true, opacity: 0.55, roughness: 0.5 }));
          s.shell.raycast = () => {};
          this.scene.add(s.shell);
        }
      }
      if (this.withHidden && !s.hidden) s.hidden = new Float32Array(await fetchBytes(`/api/object/${i}/hidden`), 8);
    } catch (e) { this.onTrouble(e); }
  }

  /// For tests and legends: samples shown, share of vertices that the offset moves, triangles hidden.
  overlay(object: number): { samples: number; moved: number; hidden: number; spheres: boolean } {
    const s = this.shown[object];
    let moved = 0;
    if (s?.shell && s.surface) {
      const a = s.surface.whole.getAttribute('position').array, b = s.shell.geometry.getAttribute('position').array;
      for (let k = 0; k < a.length; k += 3) if (Math.hypot(a[k] - b[k], a[k + 1] - b[k + 1], a[k + 2] - b[k + 2]) > 1e-4) ++moved;
    }
    return {
      samples: s?.samples?.visible ? s.samples.geometry.getAttribute('position').count : 0,
      moved: s?.shell?.visible ? moved : 0, hidden: s?.hidden && this.withHidden ? s.hidden.filter((x) => x === 1).length : 0,
      spheres: s?.spheres.all.visible ?? false,
    };
  }

  /// The point of an object's surface nearest to p, as a hit.
  nearest(object: number, p: THREE.Vector3): Hit | null {
    const s = this.shown[object];
    const found = s?.surface?.mesh.geometry.boundsTree?.closestPointToPoint(p);
    if (!s?.surface || !found) return null;
    const t = found.faceIndex, [a, b, c] = s.surface.triangle(t);
    return { object, part: s.surface.partOf[t], triangle: t, point: found.point.clone(), normal: b.sub(a).cross(c.sub(a)).normalize() };
  }

  private left: Set<string> = new Set();  ///< parts that are left out, as "id/part"
  private leaves = true;                  ///< they are
  onLeft: (count: number) => void = () => {};  ///< so many are left out now
  /// Shows a part or leaves it out; what is left out is not clicked either.
  showPart(object: number, part: number, yes: boolean): void {
    const s = this.shown[object];
    if (!s?.surface) return;
    const key = `${s.id}/${part}`;
    if (yes) this.left.delete(key); else this.left.add(key);
    s.surface.show(part, yes || !this.leaves);
    this.onLeft(this.left.size);
    this.redraw();
  }
  showAll(): void { this.shown.forEach((_, i) => this.isolate(i, -1)); }
  /// Whether parts are left out at all: what is touched is seen whole.
  leaveOut(yes: boolean): void {
    if (yes === this.leaves) return;
    this.leaves = yes;
    this.shown.forEach((s, i) => this.facts[i].parts.forEach((_, p) => { if (s && this.left.has(`${s.id}/${p}`)) s.surface?.show(p, !yes); }));
    this.redraw();
  }
  /// One part alone; -1: all parts again.
  isolate(object: number, part: number): void { this.facts[object]?.parts.forEach((_, p) => this.showPart(object, p, part < 0 || p === part)); }
  isLeft(object: number, part: number): boolean { return this.leaves && this.left.has(`${this.shown[object]?.id}/${part}`); }
  /// What of the object lies before the plane is not drawn; null: all is.
  cut(plane: THREE.Plane | null, object = -1): void {
    this.shown.forEach((s, i) => {
      if (!s?.surface) return;
      const open = plane !== null && i === object;
      s.surface.mesh.material.clippingPlanes = open ? [plane] : null;
      s.surface.mesh.material.side = open || !this.facts[i].solid ? THREE.DoubleSide : THREE.FrontSide;
    });
    this.redraw();
  }

  /// The pair of one mesh and both projections that is compared: of the selected object, else the first; null: there is none.
  pair(): [number, number] | null {
    const has = (i: number) => this.facts[i]?.twin !== null && this.facts[i] !== undefined, of = [this.selected?.object ?? -1, this.focus, ...this.facts.keys()].find(has);
    return of === undefined ? null : [of, this.facts[of].twin!];
  }
  /// What one of two views shows, or again what a single one does. The way from the first view's objects to those of this one, m.
  show(view: 'left' | 'right' | 'both'): THREE.Vector3 {
    const pair = this.beside === 'twin' ? this.pair() : null, shift = new THREE.Vector3();
    this.shown.forEach((s, i) => {
      if (!s?.surface) return;
      s.surface.wear(view === 'right' && this.beside === 'layer-2');
      if (pair) s.surface.mesh.visible = view === 'both' ? this.isSeen(i) : this.isSeen(i) && i === pair[view === 'left' ? 0 : 1];
    });
    if (pair && view === 'right') shift.fromArray(this.facts[pair[1]].position).sub(new THREE.Vector3().fromArray(this.facts[pair[0]].position));
    return shift;
  }
  private isSeen(object: number): boolean { return this.surfaceAs !== 'off' && !this.hidden && object !== this.inHand; }

  select(object: number, part: number): void {
    this.selected = object < 0 ? null : { object, part };
    void this.paint();
  }

  /// The triangle that is missed, else the one with the largest value of the field that is shown; null: there is no such field.
  worst(): { hit: Hit; value: number } | null {
    let best: { object: number; triangle: number; value: number } | null = null;
    this.shown.forEach((s, object) => s?.fields.get(this.colourBy)?.forEach((value, triangle) => {
      if ((value === MISS || value >= 0) && (!best || (best.value !== MISS && (value === MISS || value > best.value)))) best = { object, triangle, value };
    }));
    const found = best as { object: number; triangle: number; value: number } | null, surface = found && this.shown[found.object]?.surface;
    if (!found || !surface) return null;
    const [a, b, c] = surface.triangle(found.triangle), point = a.clone().add(b).add(c).divideScalar(3);
    return { value: found.value, hit: { object: found.object, part: surface.partOf[found.triangle], triangle: found.triangle, point, normal: b.sub(a).cross(c.sub(a)).normalize() } };
  }

  fieldAt(object: number, kind: string, triangle: number): number | undefined { return this.shown[object]?.fields.get(kind)?.[triangle]; }
  colourOf(object: number, part: number): Rgb { return this.shown[object]?.colours[part] ?? partColour(part); }
  /// What is drawn of the objects that can be touched.
  surfaces(): THREE.Mesh[] { return this.shown.flatMap((s, i) => (s?.surface && i !== this.inHand ? [s.surface.mesh] : [])); }
  /// Every so many vertices of the objects that can be touched, or of one.
  eachVertex(only: number, every: number, see: (object: number, v: THREE.Vector3) => void): void {
    const v = new THREE.Vector3();
    this.shown.forEach((s, i) => {
      if (!s?.surface || (only >= 0 && i !== only) || i === this.inHand) return;
      const p = s.surface.whole.getAttribute('position');
      for (let k = 0; k < p.count; k += every) see(i, v.fromBufferAttribute(p, k));
    });
  }
  /// Whether all have their ambient occlusion.
  shaded(): boolean { return this.ready() && this.shown.every((s) => !s?.surface || s.surface.shaded); }
  ready(): boolean { return this.shown.length > 0 && this.shown.every((s) => s !== null); }

  /// The nearest surface along a ray. only: one object, or -1.
  cast(raycaster: THREE.Raycaster, only: number): Hit | null {
    let best: Hit | null = null, distance = Infinity;
    this.shown.forEach((s, i) => {
      if (!s?.surface || (only >= 0 && i !== only) || i === this.inHand) return;
      const { mesh, partOf } = s.surface, visible = mesh.visible;
      mesh.visible = true;
      raycaster.firstHitOnly = this.left.size === 0;
      const hit = raycaster.intersectObject(mesh, false).find((found) => !this.isLeft(i, partOf[found.faceIndex!]));
      mesh.visible = visible;
      if (!hit || hit.distance >= distance || hit.faceIndex == null) return;
      distance = hit.distance;
      best = { object: i, part: partOf[hit.faceIndex], triangle: hit.faceIndex, point: hit.point.clone(), normal: hit.face!.normal.clone() };
    });
    return best;
  }
}
