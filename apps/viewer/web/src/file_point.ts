// Points in the coordinates of an object's file: the page draws in metres, moved, scaled and turned.
import * as THREE from 'three';
import { vector } from './geometry';
import type { ObjectFacts } from './messages';

/// Axes of the world in the order of the file's, with their signs: file x, y, z.
const TURNED: Record<ObjectFacts['up'], (p: THREE.Vector3) => THREE.Vector3> = {
  x: (p) => new THREE.Vector3(p.y, p.z, p.x),
  y: (p) => p.clone(),
  z: (p) => new THREE.Vector3(p.x, -p.z, p.y),
};

export function inFile(f: ObjectFacts, p: THREE.Vector3): THREE.Vector3 {
  return TURNED[f.up](p.clone().sub(vector(f.position)).divideScalar(f.metresPerUnit)).add(vector(f.centre));
}

/// A point in the file's coordinates as text, as exact as a ten-thousandth of the object's size.
export function pointInFile(f: ObjectFacts, p: THREE.Vector3): string {
  const decimals = Math.min(Math.max(4 - Math.ceil(Math.log10(f.rMax / f.metresPerUnit)), 0), 9);
  return inFile(f, p)
    .toArray()
    .map((x) => (Math.abs(x) < 0.5 * 10 ** -decimals ? 0 : x).toFixed(decimals))
    .join(', ');
}
