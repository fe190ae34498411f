// How surfaces are drawn: where the tool presses they give way, a dimple darker than what is round it; parts can be left out.
import * as THREE from 'three';

const REACH = 0.011;  // m, of the dimple
const DEEPEST = 0.0012;

const uniforms = { dentAt: { value: new THREE.Vector3() }, dentBy: { value: new THREE.Vector3() }, dentReach: { value: REACH } };

/// The tool touches at a point and presses along `inwards` by depth, m; null: nothing touches. What a ball lies in the surface by is
/// what the surface gives way by.
export function setDent(at: THREE.Vector3 | null, inwards = new THREE.Vector3(), depth = 0): void {
  if (!at) { uniforms.dentBy.value.set(0, 0, 0); return; }
  uniforms.dentAt.value.copy(at);
  uniforms.dentBy.value.copy(inwards).multiplyScalar(DEEPEST * (1 - Math.exp(-depth / DEEPEST)));
}

/// The material, of geometry in the world's coordinates with a number `seen` a vertex.
export function dented(material: THREE.MeshStandardMaterial): THREE.MeshStandardMaterial {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nuniform vec3 dentAt, dentBy;\nuniform float dentReach;\nattribute float seen;\nvarying float dent, drawn;')
      .replace('#include <begin_vertex>', `#include <begin_vertex>
  drawn = seen;
  vec3 fromDent = (transformed - dentAt) / dentReach;
  dent = exp(-2.5 * dot(fromDent, fromDent)) * min(length(dentBy) / 0.001, 1.0);
  transformed += dentBy * exp(-1.6 * dot(fromDent, fromDent));`);
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nvarying float dent, drawn;')
      .replace('#include <color_fragment>', '#include <color_fragment>\n  if (drawn < 0.5) discard;\n  diffuseColor.rgb *= 1.0 - 0.55 * dent;');
  };
  return material;
}
