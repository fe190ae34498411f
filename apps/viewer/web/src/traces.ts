// Drawings in the scene about one point: the steps of the search for its foot, and the plane of a section with F's level sets.
import * as THREE from 'three';
import type { Section } from './section';

export class Traces {
  private group = new THREE.Group();
  private search: THREE.Object3D[] = [];
  private section: THREE.Object3D[] = [];

  constructor(
    scene: THREE.Object3D,
    private redraw: () => void,
  ) {
    scene.add(this.group);
  }

  private replace(what: 'search' | 'section', by: THREE.Object3D[]): void {
    for (const o of this[what]) {
      this.group.remove(o);
      const drawn = o as THREE.Mesh;
      drawn.geometry?.dispose();
      (drawn.material as THREE.Material | undefined)?.dispose();
    }
    for (const o of by) {
      o.raycast = () => {};
      this.group.add(o);
    }
    this[what] = by;
    this.redraw();
  }

  /// Draws a search. looked: the samples that it looked at; path: the samples where its levels ended, whose last one is joined to the point.
  setSearch(looked: THREE.Vector3[], path: THREE.Vector3[], point: THREE.Vector3 | null): void {
    if (!path.length || !point) {
      this.replace('search', []);
      return;
    }
    const inFront = { depthTest: false, transparent: true },
      geometry = (at: THREE.Vector3[]) => new THREE.BufferGeometry().setFromPoints(at);
    const ordered = <T extends THREE.Object3D>(o: T, renderOrder: number): T => Object.assign(o, { renderOrder });
    const points = (at: THREE.Vector3[], color: number, size: number, order: number) =>
      ordered(new THREE.Points(geometry(at), new THREE.PointsMaterial({ color, size, sizeAttenuation: false, ...inFront })), order);
    const line = (at: THREE.Vector3[], color: number, order: number) =>
      ordered(new THREE.Line(geometry(at), new THREE.LineBasicMaterial({ color, ...inFront })), order);
    this.replace('search', [
      points(looked, 0xffffff, 4, 12),
      line(path, 0xffe600, 13),
      points(path, 0xffe600, 7, 14),
      line([point, path[path.length - 1]], 0xd4145a, 13),
      points([point], 0xd4145a, 8, 15),
    ]);
  }

  setSection(s: Section | null): void {
    if (!s) {
      this.replace('section', []);
      return;
    }
    const at = (x: number, y: number) => s.corner.clone().addScaledVector(s.along, x).addScaledVector(s.up, y);
    const lines = (segments: number[], colour: THREE.Color, opacity: number) => {
      const ends: THREE.Vector3[] = [];
      for (let i = 0; i < segments.length; i += 2) ends.push(at(segments[i], segments[i + 1]));
      return new THREE.LineSegments(
        new THREE.BufferGeometry().setFromPoints(ends),
        new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }),
      );
    };
    const border = lines([0, 0, 1, 0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 1, 0, 0], new THREE.Color(0x777777), 0.8);
    this.replace('section', [
      border,
      ...s.levels.map((l) => lines(l.segments, new THREE.Color().setRGB(...l.colour, THREE.SRGBColorSpace), 1)),
    ]);
  }

  /// For tests: how many points and lines are drawn.
  count(): { search: number; section: number } {
    return { search: this.search.length, section: this.section.length };
  }
}
