// The tool that is held, the arrow of its force, and the mark of a point, as three.js draws them.
import * as THREE from 'three';
import { geometryOf, vector } from './geometry';
import type { Frame } from './messages';

const ARROW = 0.03; // m of arrow a newton
const HEAD = 0.0145; // m, the arrow's head
const COILS = 7,
  STEPS = 16;
const STILL = 2e-5; // m (and radians): less is no motion
const END_ON = 0.94; // cosine of the angle to the line of sight: nearer, an arrow is a ring
const LEAST_SPRING = 0.0003; // m: shorter ones are not drawn

/// A spring of unit length along y, its first and last tenth straight.
function coil(): THREE.BufferGeometry {
  const points = [new THREE.Vector3()];
  for (let i = 0; i <= COILS * STEPS; ++i) {
    const t = i / (COILS * STEPS),
      a = 2 * Math.PI * COILS * t;
    points.push(new THREE.Vector3(Math.cos(a), 0.1 + 0.8 * t, Math.sin(a)));
  }
  points.push(new THREE.Vector3(0, 1, 0));
  return new THREE.BufferGeometry().setFromPoints(points);
}

/// A mesh that is drawn over all that is drawn before it.
function inFront(geometry: THREE.BufferGeometry, color: number, order: number): THREE.Mesh {
  const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color, depthTest: false }));
  mesh.renderOrder = order;
  return mesh;
}

export class Tool {
  private mesh: THREE.Mesh;
  private ball: THREE.SphereGeometry;
  private rim: THREE.Mesh;
  private vertices: Float32Array | null = null;
  private arrow = new THREE.Group();
  private shaft: THREE.Mesh;
  private head: THREE.Mesh;
  private shaftEdge: THREE.Mesh; ///< white edges, so that the arrow is seen on every colour
  private headEdge: THREE.Mesh;
  private ring: THREE.Group; ///< stands for an arrow that points at the eye or away from it
  private marker: THREE.Mesh;
  private hand: THREE.Mesh; ///< stands where the hand is, below the surface that holds the tool
  private spring: THREE.Line; ///< joins the tool and the hand

  constructor(
    scene: THREE.Scene,
    private redraw: () => void,
  ) {
    const ball = (this.ball = new THREE.SphereGeometry(1, 32, 24));
    // Black with a white rim is seen on every part's colour, in light and dark.
    this.mesh = new THREE.Mesh(ball, new THREE.MeshStandardMaterial({ color: 0x14181d, roughness: 0.35 }));
    const rim = (this.rim = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: 0xffffff, side: THREE.BackSide })));
    rim.scale.setScalar(1.18);
    this.mesh.add(rim);
    this.mesh.scale.setScalar(0.006);
    this.mesh.visible = false;
    scene.add(this.mesh);
    this.shaft = inFront(new THREE.CylinderGeometry(0.0016, 0.0016, 1, 12).translate(0, 0.5, 0), 0xd4145a, 10);
    this.head = inFront(new THREE.ConeGeometry(0.0045, 0.011, 16).translate(0, 0.0055, 0), 0xd4145a, 10);
    this.shaftEdge = inFront(new THREE.CylinderGeometry(0.0026, 0.0026, 1, 12).translate(0, 0.5, 0), 0xffffff, 9);
    this.headEdge = inFront(new THREE.ConeGeometry(0.0064, HEAD, 16).translate(0, 0.0056, 0), 0xffffff, 9);
    this.arrow.add(this.shaftEdge, this.headEdge, this.shaft, this.head);
    this.arrow.visible = false;
    this.arrow.renderOrder = 10;
    scene.add(this.arrow);
    this.ring = new THREE.Group();
    this.ring.add(
      inFront(new THREE.TorusGeometry(0.0125, 0.0016, 8, 40), 0xffffff, 9),
      inFront(new THREE.TorusGeometry(0.0125, 0.0009, 8, 40), 0xd4145a, 10),
    );
    this.ring.visible = false;
    scene.add(this.ring);
    this.hand = inFront(ball, 0xffe600, 9);
    this.hand.scale.setScalar(0.0016);
    const dark = inFront(ball, 0x14181d, 8);
    dark.scale.setScalar(1.35);
    this.hand.add(dark);
    this.spring = new THREE.Line(coil(), new THREE.LineBasicMaterial({ color: 0xffe600, depthTest: false }));
    this.spring.renderOrder = 9;
    this.spring.frustumCulled = false;
    this.hand.visible = this.spring.visible = false;
    scene.add(this.hand, this.spring);
    this.marker = inFront(ball, 0xd4145a, 11);
    this.marker.scale.setScalar(0.0022);
    this.marker.visible = false;
    // The mark does not grow on the screen when the eye comes near.
    this.marker.onBeforeRender = (_renderer, _scene, camera) => {
      this.marker.scale.setScalar(
        0.0022 * Math.min(1, this.marker.position.distanceTo(camera.getWorldPosition(new THREE.Vector3())) / 0.4),
      );
      this.marker.updateMatrixWorld();
      this.marker.modelViewMatrix.multiplyMatrices(camera.matrixWorldInverse, this.marker.matrixWorld);
    };
    scene.add(this.marker);
  }

  private drawn: number[] | null = null;
  private radius = 0.006;
  setRadius(r: number): void {
    if (r === this.radius) return;
    this.radius = r;
    if (!this.vertices) this.mesh.scale.setScalar(r);
    this.redraw();
  }

  /// Sets the shape of the tool: triangles about its centre, or null for a ball.
  setShape(positions: Float32Array | null, corners: Uint32Array | null): void {
    if (this.mesh.geometry !== this.ball) this.mesh.geometry.dispose();
    this.vertices = positions;
    const material = this.mesh.material as THREE.MeshStandardMaterial;
    this.rim.visible = !positions;
    material.transparent = !!positions;
    material.opacity = positions ? 0.82 : 1;
    material.color.set(positions ? 0x39424d : 0x14181d);
    material.needsUpdate = true;
    if (positions && corners) {
      this.mesh.geometry = geometryOf(positions, corners);
      this.mesh.scale.setScalar(1);
    } else {
      this.mesh.geometry = this.ball;
      this.mesh.scale.setScalar(this.radius);
    }
    this.redraw();
  }

  /// The radius of a mesh about its centre, by which the hand lifts it clear of what lies beside; 0 for the ball.
  span(): number {
    const p = this.vertices;
    let most = 0;
    if (p) for (let k = 0; k < p.length; k += 3) most = Math.max(most, Math.hypot(p[k], p[k + 1], p[k + 2]));
    return most;
  }

  /// The point of the tool, from its centre, that touches a surface with this normal first.
  tip(normal: THREE.Vector3): THREE.Vector3 {
    const p = this.vertices;
    if (!p) return normal.clone().multiplyScalar(-this.radius);
    let least = Infinity,
      best = 0;
    for (let k = 0; k < p.length; k += 3) {
      const d = p[k] * normal.x + p[k + 1] * normal.y + p[k + 2] * normal.z;
      if (d < least) {
        least = d;
        best = k;
      }
    }
    return vector(p, best);
  }

  /// Draws the tool, the hand and the force of a frame; null: hides them. inSight: the share of a line that can be seen.
  show(frame: Frame | null, inSight: (from: THREE.Vector3, to: THREE.Vector3) => number = () => 1): void {
    // A tool that stands still is not drawn again, so that the stage comes to rest and is drawn in full.
    const now = frame && [...frame.tool, ...frame.hand, ...frame.turn, ...frame.force.map((f) => ARROW * f)];
    if (!now || !this.drawn?.every((x, i) => Math.abs(x - now[i]) < STILL)) {
      this.drawn = now;
      this.redraw();
    }
    this.mesh.visible = frame !== null;
    this.arrow.visible = this.ring.visible = this.hand.visible = this.spring.visible = this.drawsForce = false;
    if (!frame) return;
    this.mesh.position.fromArray(frame.tool);
    const m = frame.turn;
    this.mesh.quaternion.setFromRotationMatrix(
      new THREE.Matrix4().set(m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, 0, 0, 0, 1),
    );
    this.showSpring(vector(frame.hand));
    const force = vector(frame.force),
      at = this.mesh.position,
      length = ARROW * force.length(),
      all = length + HEAD;
    const seen = length > 0 ? inSight(at, at.clone().addScaledVector(force, (ARROW * all) / length)) : 1;
    this.placeArrow(at, force, 1, seen < 1 ? Math.max(seen * all - HEAD, 0.1 * length) / length : 1);
  }

  /// Draws the spring from the tool to the hand, where they are apart.
  private showSpring(hand: THREE.Vector3): void {
    const along = hand.clone().sub(this.mesh.position),
      length = along.length();
    this.hand.visible = this.spring.visible = length > LEAST_SPRING;
    if (!this.spring.visible) return;
    this.hand.position.copy(hand);
    this.spring.position.copy(this.mesh.position);
    this.spring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
    this.spring.scale.set(0.0018, length, 0.0018);
  }

  /// For tests: the length of the spring as it is drawn; 0 where it is not.
  springNow(): number {
    return this.spring.visible ? this.spring.scale.y : 0;
  }

  /// Draws an arrow of force at a point; null: none. thick: times the usual thickness, for larger scenes.
  showArrow(at: THREE.Vector3 | null, force = new THREE.Vector3(), thick = 1): void {
    this.placeArrow(at, force, thick, 1);
    this.redraw();
  }
  private placeArrow(at: THREE.Vector3 | null, force: THREE.Vector3, thick: number, share: number): void {
    const size = force.length(),
      length = share * ARROW * size;
    this.arrow.visible = this.ring.visible = false;
    this.drawsForce = at !== null && size >= 0.02;
    if (!at || !this.drawsForce) return;
    this.ring.position.copy(at);
    this.ring.scale.setScalar(thick);
    this.arrow.position.copy(at);
    this.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.clone().divideScalar(size));
    for (const shaft of [this.shaft, this.shaftEdge]) shaft.scale.set(thick, length, thick);
    for (const head of [this.head, this.headEdge]) {
      head.scale.setScalar(thick);
      head.position.y = length;
    }
    this.turnTo(this.eye);
  }

  private drawsForce = false;
  private eye: THREE.Camera | null = null;
  /// Draws the force for an eye: an arrow that is seen nearly end-on would cover the contact, and is a ring about it.
  turnTo(eye: THREE.Camera | null): void {
    this.eye = eye;
    if (!eye) {
      this.arrow.visible = this.drawsForce;
      return;
    }
    const along = new THREE.Vector3(0, 1, 0).applyQuaternion(this.arrow.quaternion),
      sight = eye.getWorldPosition(new THREE.Vector3()).sub(this.arrow.position).normalize();
    this.ring.visible = this.drawsForce && Math.abs(along.dot(sight)) > END_ON;
    this.arrow.visible = this.drawsForce && !this.ring.visible;
    if (this.ring.visible) eye.getWorldQuaternion(this.ring.quaternion);
  }

  /// The end of the arrow, or the right edge of the ring; null where neither is drawn.
  tipOfArrow(): THREE.Vector3 | null {
    if (this.ring.visible) return new THREE.Vector3(0.016, 0, 0).applyQuaternion(this.ring.quaternion).add(this.ring.position);
    return this.arrow.visible
      ? new THREE.Vector3(0, this.head.position.y + 0.012, 0).applyQuaternion(this.arrow.quaternion).add(this.arrow.position)
      : null;
  }

  /// For tests: whether a force is drawn, as an arrow or a ring, its direction and length.
  arrowNow(): { visible: boolean; ring: boolean; direction: number[]; length: number } {
    const d = new THREE.Vector3(0, 1, 0).applyQuaternion(this.arrow.quaternion);
    return { visible: this.drawsForce, ring: this.ring.visible, direction: d.toArray(), length: this.shaft.scale.y };
  }

  /// For tests: the position of the mark.
  marked(): THREE.Vector3 {
    return this.marker.position;
  }
  mark(p: THREE.Vector3 | null): void {
    this.marker.visible = p !== null;
    if (p) this.marker.position.copy(p);
    this.redraw();
  }
}
