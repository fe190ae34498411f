// A surface as it is drawn. Vertices are shared within a part and double between parts: colours end where parts do, and within a
// part a field runs smoothly from vertex to vertex.
import * as THREE from 'three';
import { MISS, type Rgb, type Scale } from './colours';
import { geometryOf, treeOf } from './geometry';
import { meter } from './meter';
import { look } from './skin';

const RAYS = 24,
  REACH = 0.7; // for the shade: rays a vertex, and their length as a share of the object's radius
const SLICE = 6; // ms of shading at a time

export const linear = (c: Rgb, scale = 1): THREE.Color =>
  new THREE.Color().setRGB(...(c.map((x) => scale * x) as Rgb), THREE.SRGBColorSpace);

/// The colours of a surface: a field with its scale, else a colour for each part; over them the triangles whose mark is 1.
export interface Paint {
  parts: THREE.Color[];
  field: { values: Float32Array; scale: Scale } | null;
  marks: Float32Array | null;
  mark: THREE.Color;
}

export class Surface {
  readonly mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshLambertMaterial>;
  readonly whole: THREE.BufferGeometry; ///< with the file's own vertices
  private corners: Uint32Array;
  private from: number[] = []; ///< the file's vertex of each vertex that is drawn
  private own: THREE.BufferAttribute; ///< colours
  private other: THREE.BufferAttribute | null = null;
  private gone = false;
  shaded = false;

  constructor(
    positions: Float32Array,
    triangles: Uint32Array,
    readonly partOf: Uint32Array,
    solid: boolean,
  ) {
    this.whole = geometryOf(positions, triangles);
    this.corners = this.split(triangles, positions.length / 3);
    const geometry = new THREE.BufferGeometry(),
      normals = this.whole.getAttribute('normal').array;
    const each = (values: ArrayLike<number>) =>
      new THREE.BufferAttribute(
        Float32Array.from({ length: 3 * this.from.length }, (_, i) => values[3 * this.from[Math.floor(i / 3)] + (i % 3)]),
        3,
      );
    geometry.setIndex(new THREE.BufferAttribute(this.corners, 1));
    geometry.setAttribute('position', each(positions));
    geometry.setAttribute('normal', each(normals));
    geometry.setAttribute('color', (this.own = new THREE.BufferAttribute(new Float32Array(3 * this.from.length), 3)));
    geometry.setAttribute('look', new THREE.BufferAttribute(new Uint8Array(2 * this.from.length).fill(255), 2, true)); // seen or left out, light from all sides
    geometry.computeBoundsTree({ indirect: true } as never);
    this.mesh = new THREE.Mesh(
      geometry,
      look(
        new THREE.MeshLambertMaterial({
          vertexColors: true,
          polygonOffset: true,
          polygonOffsetFactor: 1,
          polygonOffsetUnits: 1,
          side: solid ? THREE.FrontSide : THREE.DoubleSide,
        }),
      ),
    );
  }

  private split(triangles: Uint32Array, count: number): Uint32Array {
    const first = new Int32Array(count).fill(-1),
      ofPart: number[] = [],
      more = new Map<number, number>();
    return triangles.map((v, i) => {
      const part = this.partOf[Math.floor(i / 3)],
        add = () => {
          ofPart.push(part);
          return this.from.push(v) - 1;
        };
      if (first[v] < 0) return (first[v] = add());
      if (ofPart[first[v]] === part) return first[v];
      const key = v * 65536 + part;
      let own = more.get(key);
      if (own === undefined) more.set(key, (own = add()));
      return own;
    });
  }

  /// The surface was moved by so much.
  moved(by: THREE.Vector3): void {
    this.whole.translate(by.x, by.y, by.z);
    this.mesh.geometry.boundsTree!.refit();
  }

  /// A triangle, counter-clockwise seen from outside.
  triangle(t: number): THREE.Triangle {
    const [a, b, c] = this.corners.subarray(3 * t, 3 * t + 3);
    return new THREE.Triangle().setFromAttributeAndIndices(this.mesh.geometry.getAttribute('position'), a, b, c);
  }

  /// The share of the area whose triangles have the value 1.
  shareOf(values: Float32Array): number {
    let all = 0,
      some = 0;
    for (let t = 0; t < values.length; ++t) {
      const area = this.triangle(t).getArea();
      all += area;
      if (values[t] === 1) some += area;
    }
    return some / Math.max(all, 1e-12);
  }

  /// A value for each vertex that is drawn: the mean over its triangles with a known value. Where most of its triangles have none, and
  /// where one is missed, the vertex takes the value of such a triangle.
  private atVertices(values: Float32Array, known: (value: number) => boolean): Float32Array {
    const n = this.from.length,
      sum = new Float32Array(n),
      some = new Uint16Array(n),
      all = new Uint16Array(n),
      none = new Float32Array(n);
    this.corners.forEach((v, i) => {
      const x = values[Math.floor(i / 3)];
      ++all[v];
      if (known(x)) {
        sum[v] += x;
        ++some[v];
      } else if (none[v] !== MISS) none[v] = x;
    });
    return sum.map((x, v) => (none[v] !== MISS && 2 * some[v] >= all[v] ? x / some[v] : none[v]));
  }

  /// Sets the colours for a second view; null: those of the first.
  second(paint: Paint | null): void {
    this.other = paint && new THREE.BufferAttribute(new Float32Array(3 * this.from.length), 3);
    if (paint) this.fill(this.other!, paint);
  }
  wear(other: boolean): void {
    this.mesh.geometry.setAttribute('color', (other && this.other) || this.own);
  }
  colour(paint: Paint): void {
    this.fill(this.own, paint);
  }

  private fill(attribute: THREE.BufferAttribute, { parts, field, marks, mark }: Paint): void {
    const array = attribute.array as Float32Array,
      own = new THREE.Color(),
      put = (v: number, c: THREE.Color) => {
        array[3 * v] = c.r;
        array[3 * v + 1] = c.g;
        array[3 * v + 2] = c.b;
      };
    if (field?.scale.isOfKinds)
      this.corners.forEach((v, i) => put(v, own.setRGB(...field.scale.of(field.values[Math.floor(i / 3)]), THREE.SRGBColorSpace)));
    else if (field)
      this.atVertices(field.values, field.scale.known).forEach((x, v) =>
        put(v, own.setRGB(...field.scale.of(x), THREE.SRGBColorSpace)),
      );
    else this.corners.forEach((v, i) => put(v, parts[this.partOf[Math.floor(i / 3)]]));
    if (marks)
      this.atVertices(marks, () => true).forEach((x, v) => {
        if (x >= 0.5) put(v, mark);
      });
    meter.coloured += this.partOf.length;
    attribute.needsUpdate = true;
  }

  /// Shows a part or leaves it out.
  show(part: number, yes: boolean): void {
    const attribute = this.mesh.geometry.getAttribute('look') as THREE.BufferAttribute;
    this.corners.forEach((v, i) => {
      if (this.partOf[Math.floor(i / 3)] === part) attribute.array[2 * v] = yes ? 255 : 0;
    });
    attribute.needsUpdate = true;
  }

  /// Ambient occlusion, baked in the browser's spare time: how much of the sky over each vertex its own surface leaves open.
  async shade(done: () => void): Promise<void> {
    const tree = treeOf(this.mesh),
      p = this.whole.getAttribute('position'),
      n = this.whole.getAttribute('normal');
    this.whole.computeBoundingSphere();
    const reach = REACH * this.whole.boundingSphere!.radius,
      ray = new THREE.Ray(),
      up = new THREE.Vector3(),
      side = new THREE.Vector3(),
      across = new THREE.Vector3();
    const open = new Float32Array(p.count);
    let until = 0;
    for (let v = 0; v < p.count; ++v) {
      if (performance.now() > until) {
        await new Promise<void>((resolve) => {
          if ('requestIdleCallback' in window) requestIdleCallback(() => resolve(), { timeout: 200 });
          else setTimeout(resolve, 20);
        });
        if (this.gone) return;
        until = performance.now() + SLICE;
      }
      up.fromBufferAttribute(n, v);
      side
        .set(Math.abs(up.x) < 0.7 ? 1 : 0, Math.abs(up.x) < 0.7 ? 0 : 1, 0)
        .cross(up)
        .normalize();
      across.crossVectors(up, side);
      ray.origin.fromBufferAttribute(p, v).addScaledVector(up, 2e-3 * reach);
      for (let k = 0; k < RAYS; ++k) {
        // The rays are spread evenly by cosine, and turned anew at every vertex.
        const h = Math.sqrt((k + 0.5) / RAYS),
          a = 2.39996 * k + 1.7 * v,
          z = Math.sqrt(1 - h * h);
        ray.direction
          .copy(side)
          .multiplyScalar(h * Math.cos(a))
          .addScaledVector(across, h * Math.sin(a))
          .addScaledVector(up, z);
        const hit = tree.raycastFirst(ray, THREE.DoubleSide);
        open[v] += hit && hit.distance < reach ? hit.distance / reach : 1;
      }
    }
    const attribute = this.mesh.geometry.getAttribute('look') as THREE.BufferAttribute;
    this.smoothed(open).forEach((x, v) => {
      attribute.array[2 * v + 1] = Math.round(255 * Math.min(x / RAYS, 1));
    });
    attribute.needsUpdate = true;
    this.shaded = true;
    done();
  }

  /// The mean of each drawn vertex with its neighbours: a few rays alone are grainy.
  private smoothed(open: Float32Array): Float32Array {
    const sum = open.slice(),
      count = new Float32Array(open.length).fill(1);
    for (let i = 0; i < this.corners.length; ++i) {
      const v = this.from[this.corners[i]],
        next = this.from[this.corners[i % 3 === 2 ? i - 2 : i + 1]];
      sum[v] += open[next];
      ++count[v];
    }
    return Float32Array.from(this.from, (v) => sum[v] / count[v]);
  }

  dispose(): void {
    this.gone = true;
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.whole.dispose();
  }
}
