// The dressed figure's skin.
import * as THREE from 'three';
import { geometryOf, trianglesAt } from './geometry';

const SKIN = 0xd9b99b;

/// The figure's skin: each vertex follows up to four bones.
export class Figure {
  readonly mesh: THREE.Mesh;
  private rest: Float32Array;
  private bones: Uint32Array;
  private weights: Float32Array;

  constructor(data: ArrayBuffer, at: number, vertices: number, triangles: number) {
    const [rest, corners] = trianglesAt(data, at, vertices, triangles);
    const more = at + 12 * vertices + 12 * triangles;
    this.rest = rest;
    this.bones = new Uint32Array(data, more, 4 * vertices);
    this.weights = new Float32Array(data, more + 16 * vertices, 4 * vertices);
    this.mesh = new THREE.Mesh(geometryOf(rest.slice(), corners), new THREE.MeshStandardMaterial({ color: SKIN, roughness: 0.75 }));
    this.mesh.frustumCulled = false;
  }

  /// poses: 12 numbers a bone, the rows of its map and the shift.
  pose(poses: Float32Array): void {
    const attribute = this.mesh.geometry.getAttribute('position') as THREE.BufferAttribute,
      out = attribute.array as Float32Array;
    for (let v = 0; 3 * v < out.length; ++v) {
      const x = this.rest[3 * v],
        y = this.rest[3 * v + 1],
        z = this.rest[3 * v + 2];
      let px = 0,
        py = 0,
        pz = 0;
      for (let k = 4 * v; k < 4 * v + 4; ++k) {
        const w = this.weights[k];
        if (w === 0) continue;
        const m = 12 * this.bones[k];
        px += w * (poses[m] * x + poses[m + 1] * y + poses[m + 2] * z + poses[m + 9]);
        py += w * (poses[m + 3] * x + poses[m + 4] * y + poses[m + 5] * z + poses[m + 10]);
        pz += w * (poses[m + 6] * x + poses[m + 7] * y + poses[m + 8] * z + poses[m + 11]);
      }
      out[3 * v] = px;
      out[3 * v + 1] = py;
      out[3 * v + 2] = pz;
    }
    attribute.needsUpdate = true;
    this.mesh.geometry.computeVertexNormals();
    this.mesh.geometry.boundingSphere = null;
  }
}
