// Triangles as the program sends them: three 32-bit floats a vertex, then three vertex numbers a triangle.
import * as THREE from 'three';
import type { MeshBVH } from 'three-mesh-bvh';

/// Views of v vertices and t triangles that begin at an offset of the program's bytes.
export const trianglesAt = (data: ArrayBuffer, at: number, v: number, t: number): [Float32Array, Uint32Array] => [
  new Float32Array(data, at, 3 * v),
  new Uint32Array(data, at + 12 * v, 3 * t),
];

/// Indexed triangles with smooth normals. The geometry keeps the arrays.
export function geometryOf(positions: Float32Array, corners: Uint32Array): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(corners, 1));
  geometry.computeVertexNormals();
  return geometry;
}

/// Three numbers as a vector.
export const vector = (numbers: ArrayLike<number>, from = 0): THREE.Vector3 =>
  new THREE.Vector3(numbers[from], numbers[from + 1], numbers[from + 2]);

/// The tree over a mesh's triangles, once computeBoundsTree has made it.
export const treeOf = (mesh: THREE.Mesh): MeshBVH => mesh.geometry.boundsTree as MeshBVH;
