// The material of surfaces: they give way under the tool in a dark dimple, parts can be left out, and vertices that see little of the
// sky are darker.
import * as THREE from 'three';

const REACH = 0.011; // m, the dimple's radius
const DEEPEST = 0.0012;

const uniforms = { dentAt: { value: new THREE.Vector3() }, dentBy: { value: new THREE.Vector3() }, dentReach: { value: REACH } };

/// Dents the surface at a point along `inwards` by the depth of the contact, m; null: nothing touches.
export function setDent(at: THREE.Vector3 | null, inwards = new THREE.Vector3(), depth = 0): void {
  if (!at) {
    uniforms.dentBy.value.set(0, 0, 0);
    return;
  }
  uniforms.dentAt.value.copy(at);
  uniforms.dentBy.value.copy(inwards).multiplyScalar(DEEPEST * (1 - Math.exp(-depth / DEEPEST)));
}

/// The material, of geometry in the world's coordinates with two numbers `look` a vertex: 1 where it is drawn, and how much light
/// comes to it from all sides.
export function look(material: THREE.MeshLambertMaterial): THREE.MeshLambertMaterial {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    // A part that is left out shrinks to a point. Discarding its fragments would disable the early depth test for all others.
    shader.vertexShader = shader.vertexShader
      .replace(
        '#include <common>',
        '#include <common>\nuniform vec3 dentAt, dentBy;\nuniform float dentReach;\nattribute vec2 look;\nvarying float dent, open;',
      )
      .replace(
        '#include <begin_vertex>',
        `#include <begin_vertex>
  open = look.y;
  vec3 fromDent = (transformed - dentAt) / dentReach;
  float far = dot(fromDent, fromDent);
  dent = 0.55 * exp(-2.5 * far) * min(length(dentBy) / 0.001, 1.0);
  transformed += dentBy * exp(-1.6 * far);
  transformed *= look.x;`,
      );
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nvarying float dent, open;')
      .replace('#include <color_fragment>', '#include <color_fragment>\n  diffuseColor.rgb *= 1.0 - dent;')
      .replace('#include <aomap_fragment>', 'reflectedLight.indirectDiffuse *= open * open;');
  };
  return material;
}
