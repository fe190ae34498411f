// The objects as three.js draws them: surfaces, superquadrics, spheres and overlays, coloured by part or by field.
import * as THREE from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { acceleratedRaycast, computeBoundsTree, disposeBoundsTree } from 'three-mesh-bvh';
import { colourField, distinctColours, MISS, partColour, type Range, type Rgb, type Scale } from './colours';
import { meter } from './meter';
import { geometryOf, treeOf, trianglesAt, vector } from './geometry';
import type { ObjectFacts } from './messages';
import { fetchBytes } from './net';
import { linear, Surface } from './surface';

THREE.Mesh.prototype.raycast = acceleratedRaycast;
THREE.BufferGeometry.prototype.computeBoundsTree = computeBoundsTree;
THREE.BufferGeometry.prototype.disposeBoundsTree = disposeBoundsTree;

export interface Hit {
  object: number;
  part: number;
  triangle: number;
  point: THREE.Vector3;
  normal: THREE.Vector3;
}

interface Shown {
  id: number;
  revision: number;
  at: THREE.Vector3; ///< where it is drawn; the program may have moved it since
  surface: Surface | null;
  superquadrics: Pieces<THREE.Mesh>;
  spheres: Pieces<THREE.LineSegments>;
  fields: Map<string, Float32Array>;
  colours: Rgb[];
  samples: THREE.Points | null;
  shell: THREE.Mesh | null;
  hidden: Float32Array | null;
  painted: string;
}

/// A thing for each part, which one call draws together. The vertices of piece p are those from first[p] to first[p + 1].
interface Pieces<T extends THREE.Mesh | THREE.LineSegments> {
  all: T;
  first: number[];
}

function joined<T extends THREE.Mesh | THREE.LineSegments>(
  pieces: THREE.BufferGeometry[],
  colours: THREE.Color[],
  make: (geometry: THREE.BufferGeometry) => T,
): Pieces<T> {
  const first = [0];
  pieces.forEach((piece, p) => {
    const { count } = piece.getAttribute('position'),
      rgba = [...colours[p].toArray(), 1];
    piece.setAttribute(
      'color',
      new THREE.BufferAttribute(
        Float32Array.from({ length: 4 * count }, (_, k) => rgba[k % 4]),
        4,
      ),
    );
    first.push(first[p] + count);
  });
  const all = make(mergeGeometries(pieces));
  all.raycast = () => {};
  return { all, first };
}

/// Sets the opacity of each piece, 0 to 1.
function setOpacity(pieces: Pieces<THREE.Mesh | THREE.LineSegments>, of: (piece: number) => number): void {
  const colour = pieces.all.geometry.getAttribute('color') as THREE.BufferAttribute,
    array = colour.array as Float32Array;
  let changed = false;
  for (let p = 0; p + 1 < pieces.first.length; ++p) {
    const opacity = Math.fround(of(p)),
      from = pieces.first[p];
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
  beside: 'none' | 'layer-2' | 'twin' = 'none'; ///< the content of a second view beside the first
  range: Range = null; ///< the values at which the field's colours end; null: as its values are
  surfaceAs: 'solid' | 'clear' | 'wire' | 'off' = 'solid';
  withSuperquadrics = false;
  withSpheres = false;
  withSamples = false;
  withOffset = false; ///< the surface as eq. 12 moves it out
  withHidden = false; ///< Q2: the surface that lies behind other surface of its part's projection
  inHand = -1; ///< the object that is held as the tool
  hiddenShare: string[] = [];
  focus = -1; ///< the object that is looked at: the others are pale; -1: all alike
  hidden = false; ///< recognition: nothing but the tool
  dims = true; ///< parts beside the selected one are pale
  onScale: (scale: Scale | null) => void = () => {};
  onWait: (kind: string, done: number, of: number) => void = () => {}; ///< fields that the program computes
  onTrouble: (what: unknown) => void = () => {};
  private facts: ObjectFacts[] = [];
  private shown: (Shown | null)[] = [];
  private selected: { object: number; part: number } | null = null;

  constructor(
    private scene: THREE.Scene,
    private redraw: () => void,
  ) {}

  /// The box of all objects, or of one, in the world, m.
  box(object = -1): THREE.Box3 {
    const box = new THREE.Box3();
    this.facts.forEach((f, i) => {
      if (object >= 0 ? i !== object : f.hidden) return;
      box.union(new THREE.Box3().setFromCenterAndSize(vector(f.position), vector(f.half).multiplyScalar(2)));
    });
    return box;
  }

  get count(): number {
    return this.facts.length;
  }
  /// The height of the lowest point of any object, at most 0, m.
  get low(): number {
    return Math.min(0, ...this.facts.filter((f) => !f.hidden).map((f) => f.position[1] - f.half[1]));
  }

  /// Fetches what is new, removes what is gone.
  async set(facts: ObjectFacts[]): Promise<void> {
    this.facts = facts;
    const before = this.shown;
    this.shown = facts.map((f) => before.find((s) => s && s.id === f.id && s.revision === f.revision) ?? null);
    for (const s of before) if (s && !this.shown.includes(s)) this.remove(s);
    for (const s of this.shown) s?.fields.delete('difference'); // it may have a twin now, or another
    this.shown.forEach((s, i) => {
      if (s) this.moveTo(s, vector(facts[i].position));
    });
    await Promise.all(
      facts.map(async (f, i) => {
        if (this.shown[i]) return;
        const [mesh, superquadrics] = await Promise.all([
          fetchBytes(`/api/object/${i}/mesh`),
          fetchBytes(`/api/object/${i}/superquadrics`),
        ]);
        if (this.facts !== facts) return;
        this.shown[i] = this.build(f, mesh, superquadrics);
      }),
    );
    if (this.facts === facts) await this.paint();
  }

  private drawnOf(s: Shown): (THREE.Mesh | THREE.LineSegments | THREE.Points)[] {
    return [s.surface?.mesh, s.samples, s.shell, s.superquadrics.all, s.spheres.all].filter((o) => !!o) as THREE.Mesh[];
  }
  /// Moves all that is drawn of an object to where the program has it.
  private moveTo(s: Shown, at: THREE.Vector3): void {
    const by = at.clone().sub(s.at);
    for (const o of this.drawnOf(s)) o.position.set(0, 0, 0);
    s.at.copy(at);
    if (by.lengthSq() === 0) return;
    for (const o of this.drawnOf(s)) o.geometry.translate(by.x, by.y, by.z);
    s.surface?.moved(by);
    s.painted = '';
  }
  /// Draws an object elsewhere while the user moves it.
  preview(object: number, at: THREE.Vector3): void {
    const s = this.shown[object];
    if (!s) return;
    for (const o of this.drawnOf(s)) o.position.copy(at).sub(s.at);
    this.redraw();
  }

  private remove(s: Shown): void {
    for (const key of [...this.left]) if (key.startsWith(`${s.id}/`)) this.left.delete(key);
    this.onLeft(this.left.size);
    if (s.surface) {
      this.scene.remove(s.surface.mesh);
      s.surface.dispose();
    }
    for (const o of [s.samples, s.shell])
      if (o) {
        this.scene.remove(o);
        o.geometry.dispose();
      }
    for (const { all } of [s.superquadrics, s.spheres]) {
      this.scene.remove(all);
      all.geometry.dispose();
    }
  }

  private build(f: ObjectFacts, meshData: ArrayBuffer, sqData: ArrayBuffer): Shown {
    const [, nv, nt] = new Uint32Array(meshData, 0, 4),
      [positions, corners] = trianglesAt(meshData, 16, nv, nt);
    const partOf = new Uint32Array(meshData, 16 + 12 * nv + 12 * nt, nt);
    const surface = nt > 0 ? new Surface(positions, corners, partOf, f.solid) : null;
    if (surface) {
      this.scene.add(surface.mesh);
      void surface.shade(this.redraw);
    }
    const own = distinctColours(f.parts.map((p) => p.neighbours)),
      superquadrics = this.buildSuperquadrics(sqData, own),
      spheres = this.buildSpheres(f, own);
    this.scene.add(superquadrics.all, spheres.all);
    return {
      id: f.id,
      revision: f.revision,
      at: vector(f.position),
      surface,
      superquadrics,
      spheres,
      fields: new Map(),
      colours: own,
      samples: null,
      shell: null,
      hidden: null,
      painted: '',
    };
  }

  private buildSuperquadrics(data: ArrayBuffer, own: Rgb[]): Pieces<THREE.Mesh> {
    let at = 8;
    const pieces = Array.from({ length: new Uint32Array(data, 4, 1)[0] }, () => {
      const [v, t] = new Uint32Array(data, at, 2),
        piece = geometryOf(...trianglesAt(data, at + 8, v, t));
      at += 8 + 12 * v + 12 * t;
      return piece;
    });
    return joined(
      pieces,
      own.map((c) => linear(c)),
      (g) =>
        new THREE.Mesh(
          g,
          new THREE.MeshStandardMaterial({ vertexColors: true, transparent: true, roughness: 0.5, depthWrite: false }),
        ),
    );
  }

  /// Makes the spheres of section 4.1: piece 0 lies about the object, each other piece about a superquadric.
  private buildSpheres(f: ObjectFacts, own: Rgb[]): Pieces<THREE.LineSegments> {
    const ring = new THREE.EdgesGeometry(new THREE.SphereGeometry(1, 20, 14), 1);
    const pieces = [f.sphere, ...f.parts.map((p) => p.sphere)].map(([x, y, z, r]) =>
      ring.clone().scale(r, r, r).translate(x, y, z),
    );
    return joined(
      pieces,
      [new THREE.Color(0x888888), ...own.map((c) => linear(c))],
      (g) => new THREE.LineSegments(g, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false })),
    );
  }

  /// Sets colours and visibility of all objects as the choices say.
  async paint(): Promise<void> {
    const shares: string[] = [],
      kind = this.colourBy,
      other = kind === 'error' && this.beside === 'layer-2';
    if (kind !== 'parts') await this.fields(kind);
    if (other) await this.fields('error-2');
    if (this.colourBy !== kind) return;
    // One scale for all objects, so that the legend is true of each.
    const values = this.shown.map((s) => (kind === 'parts' ? undefined : s?.fields.get(kind)));
    const known = values.filter((v) => v !== undefined),
      joined = new Float32Array(known.reduce((n, v) => n + v.length, 0));
    known.reduce((at, v) => {
      joined.set(v, at);
      return at + v.length;
    }, 0);
    const scale = joined.length ? colourField(kind, joined, this.range) : null;
    await Promise.all(
      this.shown.map(async (s, i) => {
        if (!s) return;
        const there = !this.hidden && !this.facts[i].hidden && i !== this.inHand,
          baked = !this.facts[i].edited;
        const chosen = this.dims && this.selected?.object === i ? this.selected.part : -1;
        s.superquadrics.all.visible = there && (this.withSuperquadrics || !this.facts[i].hasTriangles);
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
        const material = s.surface.mesh.material,
          clear = this.surfaceAs === 'clear';
        if (material.transparent !== clear) material.needsUpdate = true;
        material.transparent = clear;
        material.wireframe = this.surfaceAs === 'wire';
        material.opacity = clear ? 0.35 : 1;
        const field = scale && values[i] ? { values: values[i], scale } : null;
        // The key names all that decides the colours; a surface that has them already is not painted again.
        const pale = this.focus >= 0 && this.focus !== i && !(this.beside === 'twin' && this.pair()?.includes(i));
        const key = `${kind}${field ? '' : '!'}|${scale?.key ?? ''}|${chosen}|${hidden ? 1 : 0}|${pale ? 1 : 0}`;
        if (s.painted === `${key}|${other}`) return;
        s.painted = `${key}|${other}`;
        const parts = s.colours.map((c, p) =>
          linear(
            pale ? (c.map((x) => 0.28 * x + 0.5) as Rgb) : chosen >= 0 && chosen !== p ? (c.map((x) => 0.45 * x + 0.4) as Rgb) : c,
          ),
        );
        meter.spend('colours', () => s.surface!.colour({ parts, field, marks: hidden, mark: linear(HIDDEN) }));
        const second = other ? s.fields.get('error-2') : undefined;
        s.surface.second(scale && second ? { parts, field: { values: second, scale }, marks: hidden, mark: linear(HIDDEN) } : null);
      }),
    );
    this.hiddenShare = shares.filter((x) => x);
    if (this.colourBy === kind) this.onScale(scale);
    this.onPaint();
    this.redraw();
  }
  onPaint: () => void = () => {}; ///< what is seen may be other than before

  /// Fetches a field of all objects. The program needs seconds for some fields; onWait says how many objects have theirs.
  private async fields(kind: string): Promise<void> {
    const missing = this.shown.flatMap((s, i) =>
      s?.surface && !s.fields.has(kind) && (kind !== 'difference' || this.facts[i].twin !== null) ? [[s, i] as const] : [],
    );
    let done = 0;
    if (missing.length) this.onWait(kind, 0, missing.length);
    await Promise.all(
      missing.map(async ([s, i]) => {
        try {
          s.fields.set(kind, new Float32Array(await fetchBytes(`/api/object/${i}/field/${kind}`), 8));
        } catch (e) {
          this.onTrouble(e);
        }
        if (this.colourBy === kind || kind === 'error-2') this.onWait(kind, ++done, missing.length);
      }),
    );
  }

  /// Fetches the overlays that are switched on, each once.
  private async overlays(s: Shown, i: number): Promise<void> {
    try {
      if (this.withSamples && !s.samples) {
        const data = await fetchBytes(`/api/object/${i}/samples`),
          n = new Uint32Array(data, 4, 1)[0];
        const g = new THREE.BufferGeometry(),
          part = new Uint32Array(data, 8 + 12 * n, n),
          colours = new Float32Array(3 * n);
        for (let k = 0; k < n; ++k) {
          const c = linear(s.colours[part[k]], 0.45);
          colours.set([c.r, c.g, c.b], 3 * k);
        }
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
        const { whole } = s.surface,
          from = whole.getAttribute('position').array,
          normal = whole.getAttribute('normal').array,
          to = new Float32Array(from.length);
        for (let k = 0; k < to.length; ++k) to[k] = from[k] + normal[k] * (out[Math.floor(k / 3)] + 1e-5);
        if (!s.shell) {
          s.shell = new THREE.Mesh(
            geometryOf(to, whole.getIndex()!.array as Uint32Array),
            new THREE.MeshStandardMaterial({ color: 0x0b9dc4, transparent: true, opacity: 0.55, roughness: 0.5 }),
          );
          s.shell.raycast = () => {};
          this.scene.add(s.shell);
        }
      }
      if (this.withHidden && !s.hidden) s.hidden = new Float32Array(await fetchBytes(`/api/object/${i}/hidden`), 8);
    } catch (e) {
      this.onTrouble(e);
    }
  }

  /// For tests: the number of samples and of hidden triangles that are drawn, and whether the offset surface and the spheres are.
  overlay(object: number): { samples: number; offset: boolean; hidden: number; spheres: boolean } {
    const s = this.shown[object];
    return {
      samples: s?.samples?.visible ? s.samples.geometry.getAttribute('position').count : 0,
      offset: s?.shell?.visible ?? false,
      hidden: s?.hidden && this.withHidden ? s.hidden.filter((x) => x === 1).length : 0,
      spheres: s?.spheres.all.visible ?? false,
    };
  }

  /// The point of an object's surface nearest to p, as a hit.
  nearest(object: number, p: THREE.Vector3): Hit | null {
    const s = this.shown[object];
    const found = s?.surface && treeOf(s.surface.mesh).closestPointToPoint(p);
    if (!s?.surface || !found) return null;
    return this.hitOf(object, s.surface, found.faceIndex, found.point.clone());
  }

  private hitOf(object: number, surface: Surface, triangle: number, point: THREE.Vector3): Hit {
    return {
      object,
      part: surface.partOf[triangle],
      triangle,
      point,
      normal: surface.triangle(triangle).getNormal(new THREE.Vector3()),
    };
  }

  private left: Set<string> = new Set(); ///< parts that are left out, as "id/part"
  private leaves = true; ///< false: they are drawn all the same
  onLeft: (count: number) => void = () => {}; ///< called with the number of parts that are left out
  /// Shows a part or leaves it out; a click passes through a part that is left out.
  showPart(object: number, part: number, yes: boolean): void {
    const s = this.shown[object];
    if (!s?.surface) return;
    const key = `${s.id}/${part}`;
    if (yes) this.left.delete(key);
    else this.left.add(key);
    s.surface.show(part, yes || !this.leaves);
    this.onLeft(this.left.size);
    this.redraw();
  }
  showAll(): void {
    this.shown.forEach((_, i) => this.isolate(i, -1));
  }
  /// Switches the leaving out of parts on or off: an object that is touched is seen whole.
  leaveOut(yes: boolean): void {
    if (yes === this.leaves) return;
    this.leaves = yes;
    this.shown.forEach((s, i) =>
      this.facts[i].parts.forEach((_, p) => {
        if (s && this.left.has(`${s.id}/${p}`)) s.surface?.show(p, !yes);
      }),
    );
    this.redraw();
  }
  /// One part alone; -1: all parts again.
  isolate(object: number, part: number): void {
    this.facts[object]?.parts.forEach((_, p) => this.showPart(object, p, part < 0 || p === part));
  }
  /// Object and part of each part that is left out.
  leftOut(): [number, number][] {
    return this.facts.flatMap((f, i) =>
      f.parts.flatMap((_, p) => (this.left.has(`${f.id}/${p}`) ? [[i, p] as [number, number]] : [])),
    );
  }
  isLeft(object: number, part: number): boolean {
    return this.leaves && this.left.has(`${this.shown[object]?.id}/${part}`);
  }
  /// Draws only the side of the object behind the plane; null: draws all of it.
  cut(plane: THREE.Plane | null, object = -1): void {
    this.shown.forEach((s, i) => {
      if (!s?.surface) return;
      const open = plane !== null && i === object;
      s.surface.mesh.material.clippingPlanes = open ? [plane] : null;
      s.surface.mesh.material.side = open || !this.facts[i].solid ? THREE.DoubleSide : THREE.FrontSide;
    });
    this.redraw();
  }

  /// The pair of objects of one mesh and both projections that a second view compares: the selected object's, or the first where
  /// nothing is selected; null where there is none.
  pair(): [number, number] | null {
    const has = (i: number) => this.facts[i]?.twin !== null && this.facts[i] !== undefined,
      of = (this.selected ? [this.selected.object] : [this.focus, ...this.facts.keys()]).find(has);
    return of === undefined ? null : [of, this.facts[of].twin!];
  }
  /// Shows the content of one of two views, or of a single one. Returns the shift from the first view's objects to this view's, m.
  show(view: 'left' | 'right' | 'both'): THREE.Vector3 {
    const pair = this.beside === 'twin' ? this.pair() : null,
      shift = new THREE.Vector3();
    this.shown.forEach((s, i) => {
      if (!s?.surface) return;
      s.surface.wear(view === 'right' && this.beside === 'layer-2');
      if (pair) s.surface.mesh.visible = view === 'both' ? this.isSeen(i) : this.isSeen(i) && i === pair[view === 'left' ? 0 : 1];
    });
    if (pair && view === 'right') shift.fromArray(this.facts[pair[1]].position).sub(vector(this.facts[pair[0]].position));
    return shift;
  }
  private isSeen(object: number): boolean {
    return this.surfaceAs !== 'off' && !this.hidden && this.isThere(object);
  }
  /// Tells whether an object can be touched and picked: it is neither hidden nor the tool.
  private isThere(object: number): boolean {
    return object !== this.inHand && !this.facts[object]?.hidden;
  }
  /// The objects whose surface is seen in a view.
  seenIn(view: 'left' | 'right' | 'both'): number[] {
    const pair = this.beside === 'twin' && view !== 'both' ? this.pair() : null;
    return this.shown.flatMap((s, i) =>
      s?.surface && this.isSeen(i) && (!pair || i === pair[view === 'left' ? 0 : 1]) ? [i] : [],
    );
  }
  /// Null: it is not drawn yet.
  meshOf(object: number): THREE.Mesh | null {
    return this.shown[object]?.surface?.mesh ?? null;
  }
  surfaceOf(object: number): THREE.Mesh {
    return this.shown[object]!.surface!.mesh;
  }

  select(object: number, part: number): void {
    this.selected = object < 0 ? null : { object, part };
    void this.paint();
  }

  /// The triangle that is missed, else the one with the largest value of the field that is shown, where it is seen; null: there is none.
  worst(): { hit: Hit; value: number } | null {
    let best: { object: number; triangle: number; value: number } | null = null;
    this.shown.forEach((s, object) =>
      (this.facts[object].hidden ? null : s)?.fields.get(this.colourBy)?.forEach((value, triangle) => {
        if ((value === MISS || value >= 0) && (!best || (best.value !== MISS && (value === MISS || value > best.value))))
          best = { object, triangle, value };
      }),
    );
    const found = best as { object: number; triangle: number; value: number } | null,
      surface = found && this.shown[found.object]?.surface;
    if (!found || !surface) return null;
    return {
      value: found.value,
      hit: this.hitOf(found.object, surface, found.triangle, surface.triangle(found.triangle).getMidpoint(new THREE.Vector3())),
    };
  }

  /// The triangles that layer 3 misses, and layer 2 where it is shown beside it. held: the objects that have some answer touch by their exact triangles.
  missedNow(): { missed: number; held: boolean; second: number } {
    let missed = 0,
      held = true,
      second = 0;
    const count = (values?: Float32Array) => values?.reduce((n, value) => n + (value === MISS ? 1 : 0), 0) ?? 0;
    this.shown.forEach((s, i) => {
      const fields = this.facts[i].hidden ? undefined : s?.fields,
        own = count(fields?.get('error'));
      if (this.beside === 'layer-2') second += count(fields?.get('error-2'));
      missed += own;
      held &&= own === 0 || this.facts[i].exact;
    });
    return { missed, held, second };
  }

  fieldAt(object: number, kind: string, triangle: number): number | undefined {
    return this.shown[object]?.fields.get(kind)?.[triangle];
  }
  colourOf(object: number, part: number): Rgb {
    return this.shown[object]?.colours[part] ?? partColour(part);
  }
  /// The surfaces of the objects that can be touched.
  surfaces(): THREE.Mesh[] {
    return this.shown.flatMap((s, i) => (s?.surface && this.isThere(i) ? [s.surface.mesh] : []));
  }
  /// Calls see with every n-th vertex of the objects that can be touched, or of one of them.
  eachVertex(only: number, every: number, see: (object: number, v: THREE.Vector3) => void): void {
    const v = new THREE.Vector3();
    this.shown.forEach((s, i) => {
      if (!s?.surface || (only >= 0 && i !== only) || !this.isThere(i)) return;
      const p = s.surface.whole.getAttribute('position');
      for (let k = 0; k < p.count; k += every) see(i, v.fromBufferAttribute(p, k));
    });
  }
  /// Tells whether all objects have their ambient occlusion.
  shaded(): boolean {
    return this.ready() && this.shown.every((s) => !s?.surface || s.surface.shaded);
  }
  ready(): boolean {
    return this.shown.length > 0 && this.shown.every((s) => s !== null);
  }

  /// The nearest surface along a ray. only: one object, or -1.
  cast(raycaster: THREE.Raycaster, only: number): Hit | null {
    let best: Hit | null = null,
      distance = Infinity;
    this.shown.forEach((s, i) => {
      if (!s?.surface || (only >= 0 && i !== only) || !this.isThere(i)) return;
      const { mesh, partOf } = s.surface,
        visible = mesh.visible;
      mesh.visible = true;
      raycaster.firstHitOnly = this.left.size === 0;
      const hit = raycaster.intersectObject(mesh, false).find((found) => !this.isLeft(i, partOf[found.faceIndex!]));
      mesh.visible = visible;
      if (!hit || hit.distance >= distance || hit.faceIndex == null) return;
      distance = hit.distance;
      best = {
        object: i,
        part: partOf[hit.faceIndex],
        triangle: hit.faceIndex,
        point: hit.point.clone(),
        normal: hit.face!.normal.clone(),
      };
    });
    return best;
  }
}
