// Points that move with the cloth: the pins that were set here, and the line of a cut.
import * as THREE from 'three';
import { world } from './stage';

const MOST_LINE = 64, // points that the program takes
  LINE_STEP = 0.012; // m between two of them

/// A point on the cloth: the shares of a triangle's corners 1 and 2.
export interface OnCloth {
  triangle: number;
  u: number;
  v: number;
}

function cornersOf(cloth: THREE.Mesh, triangle: number): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
  const g = cloth.geometry,
    index = g.getIndex()!,
    p = g.getAttribute('position') as THREE.BufferAttribute;
  const corner = (k: number) => new THREE.Vector3().fromBufferAttribute(p, index.getX(3 * triangle + k));
  return [corner(0), corner(1), corner(2)];
}
/// p: on a triangle of the cloth. Null where that has no area.
export function onCloth(cloth: THREE.Mesh, triangle: number, p: THREE.Vector3): OnCloth | null {
  const share = THREE.Triangle.getBarycoord(p, ...cornersOf(cloth, triangle), new THREE.Vector3());
  return share && { triangle, u: Math.min(Math.max(share.y, 0), 1), v: Math.min(Math.max(share.z, 0), 1) };
}

export class ClothMarks {
  private line: OnCloth[] | null = null;
  private pinned: OnCloth[] = [];
  private pinnedAt = 0;
  private pins = new THREE.Points(
    new THREE.BufferGeometry(),
    new THREE.PointsMaterial({ color: 0xffd400, size: 9, sizeAttenuation: false, depthTest: false }),
  );
  private drawn = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd4145a, depthTest: false }));

  constructor(private cloth: () => THREE.Mesh | null) {
    for (const mark of [this.drawn, this.pins]) {
      mark.frustumCulled = false;
      mark.renderOrder = 9;
      mark.visible = false;
      world.extra.add(mark);
    }
  }

  pin(p: OnCloth): void {
    this.pinned.push(p);
    this.pinnedAt = performance.now();
  }

  /// The line's newest point, where there is one.
  get tip(): THREE.Vector3 | null {
    return this.line?.length ? this.placeOf(this.line[this.line.length - 1]) : null;
  }
  begin(): void {
    this.line = [];
    this.drawLine();
  }
  extend(p: OnCloth): void {
    if (!this.line || this.line.length >= MOST_LINE) return;
    const tip = this.tip;
    if (tip && tip.distanceTo(this.placeOf(p)) < LINE_STEP) return;
    this.line.push(p);
    this.drawLine();
  }
  /// Takes the line away. Null where none was begun.
  end(): OnCloth[] | null {
    const line = this.line;
    this.line = null;
    this.drawLine();
    return line;
  }

  /// Draws the marks where the cloth is now. pinned: the vertices that the program has pinned; without any the pins go, but for
  /// new ones, of which it may not know yet.
  follow(pinned: number): void {
    if (this.line) this.drawLine();
    if (pinned === 0 && performance.now() - this.pinnedAt > 1500) this.pinned = [];
    this.pins.visible = this.pinned.length > 0;
    if (this.pins.visible) this.draw(this.pins, this.pinned);
  }

  private placeOf(p: OnCloth): THREE.Vector3 {
    const [a, b, c] = cornersOf(this.cloth()!, p.triangle);
    return a
      .multiplyScalar(1 - p.u - p.v)
      .addScaledVector(b, p.u)
      .addScaledVector(c, p.v);
  }
  private draw(mark: THREE.Points | THREE.Line, at: OnCloth[]): void {
    mark.geometry.dispose();
    mark.geometry = new THREE.BufferGeometry().setFromPoints(at.map((p) => this.placeOf(p)));
  }
  private drawLine(): void {
    this.drawn.visible = (this.line?.length ?? 0) > 1;
    if (this.drawn.visible) this.draw(this.drawn, this.line!);
    world.redraw();
  }
}
