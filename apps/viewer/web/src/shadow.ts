// A soft shadow of the objects on the ground, drawn once for a scene; it is darker under surface that is near the ground.
import * as THREE from 'three';

const BLUR = 0.008,
  DARK = 0.5; // share of the side; opacity, 0 to 1

const FULL = 'varying vec2 at; void main() { at = uv; gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0); }';
const SMOOTH = `varying vec2 at; uniform sampler2D picture; uniform vec2 step;
void main() {
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int i = -8; i <= 8; ++i) { float w = exp(-0.04 * float(i * i)); sum += w * texture2D(picture, at + float(i) * step); total += w; }
  gl_FragColor = sum / total;
}`;

export class GroundShadow {
  private plane: THREE.Mesh;
  private drawn = false; ///< an object throws a shadow
  private targets: THREE.WebGLRenderTarget[];
  private camera = new THREE.OrthographicCamera();
  private near = new THREE.ShaderMaterial({
    vertexShader:
      'varying float height; uniform float ground; void main() { vec4 p = modelMatrix * vec4(position, 1.0); height = p.y - ground; gl_Position = projectionMatrix * viewMatrix * p; }',
    fragmentShader: `varying float height; uniform float reach; void main() { gl_FragColor = vec4(0.0, 0.0, 0.0, ${DARK.toFixed(2)} * exp(-max(height, 0.0) / reach)); }`,
    uniforms: { ground: { value: 0 }, reach: { value: 0.06 } },
    side: THREE.DoubleSide,
  });
  private smooth = new THREE.ShaderMaterial({
    vertexShader: FULL,
    fragmentShader: SMOOTH,
    uniforms: { picture: { value: null }, step: { value: new THREE.Vector2() } },
    depthTest: false,
    depthWrite: false,
  });
  private screen = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), this.smooth);

  /// size: pixels along each side of its picture.
  constructor(
    scene: THREE.Scene,
    private renderer: THREE.WebGLRenderer,
    size = 512,
  ) {
    this.targets = [0, 1].map(() => new THREE.WebGLRenderTarget(size, size));
    this.plane = new THREE.Mesh(
      new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2),
      new THREE.MeshBasicMaterial({ map: this.targets[0].texture, transparent: true, depthWrite: false }),
    );
    this.plane.visible = false;
    this.plane.renderOrder = -1;
    this.plane.raycast = () => {};
    scene.add(this.plane);
    this.screen.frustumCulled = false;
  }

  set seen(yes: boolean) {
    this.plane.visible = yes && this.drawn;
  }

  /// reach: m above the ground at which a surface darkens it by a third of the most.
  /// Draws the surfaces from below, so that the one nearest to the ground counts, then smooths the picture.
  draw(surfaces: THREE.Mesh[], box: THREE.Box3, ground: number, reach = 0.06): void {
    this.drawn = surfaces.length > 0 && !box.isEmpty();
    if (!this.drawn) return;
    const size = box.getSize(new THREE.Vector3()),
      middle = box.getCenter(new THREE.Vector3()),
      half = 0.62 * Math.max(size.x, size.z) + 0.03;
    Object.assign(this.camera, { left: -half, right: half, top: half, bottom: -half, near: 0, far: size.y + 0.2 });
    this.camera.position.set(middle.x, ground - 0.01, middle.z);
    this.camera.up.set(0, 0, 1);
    this.camera.lookAt(middle.x, ground + 1, middle.z);
    this.camera.updateProjectionMatrix();
    this.near.uniforms.ground.value = ground;
    this.near.uniforms.reach.value = reach;
    const group = new THREE.Scene();
    for (const s of surfaces) {
      const copy = new THREE.Mesh(s.geometry, this.near);
      copy.raycast = () => {};
      group.add(copy);
    }
    const before = this.renderer.getClearAlpha(),
      colour = this.renderer.getClearColor(new THREE.Color());
    const { xr } = this.renderer,
      worn = xr.enabled;
    xr.enabled = false; // else the renderer would take the headset's eyes as its camera
    this.renderer.setClearColor(0x000000, 0);
    const render = (what: THREE.Object3D, target: THREE.WebGLRenderTarget) => {
      this.renderer.setRenderTarget(target);
      this.renderer.clear();
      this.renderer.render(what, this.camera);
    };
    render(group, this.targets[0]);
    for (const [x, y, from, to] of [
      [BLUR / 8, 0, 0, 1],
      [0, BLUR / 8, 1, 0],
      [BLUR / 3, 0, 0, 1],
      [0, BLUR / 3, 1, 0],
    ]) {
      this.smooth.uniforms.picture.value = this.targets[from].texture;
      this.smooth.uniforms.step.value.set(x, y);
      render(this.screen, this.targets[to]);
    }
    this.renderer.setRenderTarget(null);
    xr.enabled = worn;
    this.renderer.setClearColor(colour, before);
    this.plane.scale.set(2 * half, 1, -2 * half); // its picture's upper edge is at positive z
    (this.plane.material as THREE.MeshBasicMaterial).side = THREE.FrontSide; // from below it would darken what stands on it
    this.plane.position.set(middle.x, ground + 0.0004, middle.z);
  }
}
