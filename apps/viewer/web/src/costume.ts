// The costume designer's view: a figure that the program dresses, and hands that pull and pin its cloth.
import * as THREE from 'three';
import { GLTFExporter } from 'three/examples/jsm/exporters/GLTFExporter.js';
import { announce, fill, h } from './dom';
import type { ClothFrame, Status, Worn } from './messages';
import { fetchBytes } from './net';
import type { World } from './world';

const GARMENTS: [string, string][] = [['shirt', 'Shirt'], ['skirt', 'Skirt'], ['poncho', 'Poncho']];
const FABRICS: [string, string, number][] = [['cotton', 'Cotton', 0x3b6ea5], ['silk', 'Silk', 0xb08ad0], ['denim', 'Denim', 0x2b4a78], ['wool', 'Wool', 0xb5563c], ['leather', 'Leather', 0x6b4a32]];

const MOST_LINE = 64, LINE_STEP = 0.012;  // points that the program takes, m between them

/// A point on the cloth, wherever it goes: shares of a triangle's corners 1 and 2.
interface OnCloth { triangle: number; u: number; v: number; }

export class Costume {
  readonly element: HTMLElement;
  private garment = h('select', { id: 'garment', onchange: () => this.fit() }, ...GARMENTS.map(([v, t]) => h('option', { value: v }, t)));
  private fabric = h('select', { id: 'fabric', onchange: () => this.fit() }, ...FABRICS.map(([v, t]) => h('option', { value: v }, t)));
  private walks = h('input', { type: 'checkbox', id: 'walks', onchange: () => this.fit() });
  private pins = h('input', { type: 'radio', name: 'grip', id: 'grip-pin' });
  private cuts = h('input', { type: 'radio', name: 'grip', id: 'grip-cut' });
  private pulls = h('input', { type: 'radio', name: 'grip', id: 'grip-pull', checked: true });
  private seams = h('div', { class: 'row wrap', role: 'group', 'aria-label': 'Seams' });
  private facts = h('dl', { class: 'numbers', id: 'cloth-facts' });
  private bones: THREE.Mesh[] = [];
  private cloth: THREE.Mesh | null = null;
  private number = -1;
  private loading = false;
  private at = new THREE.Vector3();
  private cursor = new THREE.Vector2();
  private dragged: THREE.Vector3 | null = null;
  private line: OnCloth[] | null = null;
  private touched: OnCloth | null = null;  ///< what under() found last
  private draws = false;
  private pinned: OnCloth[] = [];  ///< where pins were set here
  private pinnedAt = 0;
  private pinMarks = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ color: 0xffd400, size: 9, sizeAttenuation: false, depthTest: false }));
  private drawn = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd4145a, depthTest: false }));
  private seamText = '';
  private factsDue = 0;
  held = false;
  active = false;
  frames = 0;
  last: ClothFrame | null = null;
  onReady: () => void = () => {};
  onPull: (force: number, at: THREE.Vector3) => void = () => {};  ///< N; of every frame, once its arrow is drawn
  stopped: () => boolean = () => false;  ///< then nothing can be taken, pinned or cut

  constructor(private world: World, private canvas: HTMLCanvasElement, private say: (message: object) => boolean) {
    const radio = (input: HTMLInputElement, text: string) => h('label', { class: 'check' }, input, h('span', {}, text));
    this.element = h('div', {},
      h('label', { class: 'field' }, h('span', {}, 'Garment'), this.garment),
      h('label', { class: 'field' }, h('span', {}, 'Fabric'), this.fabric),
      h('label', { class: 'check' }, this.walks, h('span', {}, 'The figure walks')),
      h('fieldset', {}, h('legend', {}, 'A press on the cloth'), radio(this.pulls, 'takes it and pulls'), radio(this.pins, 'pins it to the body, or to the air where the body is far'), radio(this.cuts, 'cuts it along the drag')),
      this.seams,
      h('div', { class: 'row wrap' }, h('button', { id: 'unpin', onclick: () => { this.say({ say: 'cloth', do: 'unpin' }); announce('Pins taken out.'); } }, 'Take pins out'),
        h('button', { id: 'dress-again', onclick: () => { this.say({ say: 'cloth', do: 'restart' }); announce('Dressed anew.'); } }, 'Start again')),
      this.facts,
      h('p', { class: 'note' }, 'Keys on the stage: arrows move the cross, Enter takes and lets go, P pins, C begins a cut and ends it, Q and E walk round.'));
    this.drawn.frustumCulled = false;
    this.drawn.renderOrder = 9;
    this.drawn.visible = false;
    this.pinMarks.frustumCulled = false;
    this.pinMarks.renderOrder = 9;
    world.extra.add(this.drawn, this.pinMarks);
    world.extra.visible = false;
    canvas.addEventListener('pointerdown', (e) => this.down(e), { capture: true });
    canvas.addEventListener('pointermove', (e) => { if (!this.active) return; if (this.held) { this.cursor.copy(this.world.onCanvas(e)); this.drag(); } else if (this.line && this.draws) { this.cursor.copy(this.world.onCanvas(e)); this.extend(); } });
    for (const type of ['pointerup', 'pointercancel'] as const) canvas.addEventListener(type, () => { if (this.line && this.draws) this.endCut(type === 'pointerup'); this.release(); });
    canvas.addEventListener('keydown', (e) => this.key(e));
    setInterval(() => { if (this.dragged) this.say({ say: 'cloth', do: 'drag', p: this.dragged.toArray().map((x) => Number(x.toFixed(5))) }); this.dragged = null; }, 16);
  }

  enter(): void {
    this.active = true;
    this.number = -1;  // whatever the program numbers next is to be fetched
    this.world.extra.visible = true;
    this.world.groundAt(0);
    this.world.frameBox(new THREE.Box3(new THREE.Vector3(-0.75, 0, -0.3), new THREE.Vector3(0.75, 1.75, 0.3)));
    this.fit();
  }
  leave(): void {
    if (!this.active) return;
    this.active = false;
    this.release();
    this.endCut(false);
    this.world.tool.showArrow(null);
    this.world.extra.visible = false;
    this.world.groundUnder();
    this.say({ say: 'undress' });
  }
  /// After a lost connection the program knows of nothing.
  again(): void { this.held = false; if (this.active) this.fit(); }

  /// What is worn, for a link, and what one says.
  chosen(): unknown[] { return [this.garment.value, this.fabric.value, this.walks.checked]; }
  choose([garment, fabric, walks]: unknown[]): void {
    if (GARMENTS.some(([g]) => g === garment)) this.garment.value = String(garment);
    if (FABRICS.some(([f]) => f === fabric)) this.fabric.value = String(fabric);
    this.walks.checked = walks === true;
  }

  /// The figure and what it wears, as they stand now.
  async glb(): Promise<ArrayBuffer | null> {
    if (!this.cloth) return null;
    const group = new THREE.Group();
    for (const mesh of [...this.bones, this.cloth]) { const copy = mesh.clone(false); copy.name = mesh === this.cloth ? this.garment.value : `bone ${group.children.length + 1}`; group.add(copy); }
    return (await new GLTFExporter().parseAsync(group, { binary: true })) as ArrayBuffer;
  }

  private fit(): void { this.say({ say: 'fit', garment: this.garment.value, fabric: this.fabric.value, walks: this.walks.checked }); this.colour(); }
  private colour(): void {
    const found = FABRICS.find(([name]) => name === this.fabric.value);
    if (this.cloth && found) { (this.cloth.material as THREE.MeshStandardMaterial).color.set(found[2]); this.world.redraw(); }
  }

  status(s: Status): void {
    const worn: Worn | null = s.cloth.worn;
    const text = JSON.stringify(worn?.seams ?? []);
    if (text === this.seamText) return;
    this.seamText = text;
    fill(this.seams, ...(worn?.seams ?? []).map((seam, i) => h('button', {
      id: `seam-${seam.name.replaceAll(' ', '-')}`, 'aria-pressed': String(!seam.sewn),
      onclick: () => { this.say({ say: 'cloth', do: seam.sewn ? 'cut' : 'sew', seam: i }); announce(`${seam.name}: ${seam.sewn ? 'opened' : 'sewn'}.`); },
    }, `${seam.sewn ? 'Open' : 'Sew'} the ${seam.name}`)));
  }

  frame(f: ClothFrame): void {
    if (!this.active) return;
    if (f.number !== this.number) { void this.load(); return; }
    if (!this.cloth || this.cloth.geometry.getAttribute('position').count * 3 !== f.positions.length) return;
    ++this.frames;
    this.last = f;
    this.bones.forEach((bone, b) => {
      const p = f.poses.subarray(12 * b, 12 * b + 12);
      bone.matrix.set(p[0], p[1], p[2], p[9], p[3], p[4], p[5], p[10], p[6], p[7], p[8], p[11], 0, 0, 0, 1);
      bone.matrixWorldNeedsUpdate = true;
    });
    const attribute = this.cloth.geometry.getAttribute('position') as THREE.BufferAttribute;
    (attribute.array as Float32Array).set(f.positions);
    attribute.needsUpdate = true;
    this.cloth.geometry.computeVertexNormals();
    if (this.line) this.drawLine();
    if (f.pinned === 0 && performance.now() - this.pinnedAt > 1500) this.pinned = [];
    this.pinMarks.visible = this.pinned.length > 0;
    if (this.pinMarks.visible) { this.pinMarks.geometry.dispose(); this.pinMarks.geometry = new THREE.BufferGeometry().setFromPoints(this.pinned.map((p) => this.placeOf(p))); }
    const pull = new THREE.Vector3(...(f.tension as [number, number, number])), size = pull.length();
    const body = new THREE.Vector3(...(f.body as [number, number, number])), pushed = body.length();
    this.world.tool.showArrow(f.held ? this.at : null, pull.add(body), 3);
    this.onPull(pull.length(), this.at);
    this.world.redraw();
    if (performance.now() < this.factsDue) return;
    this.factsDue = performance.now() + 250;
    const rows: [string, string][] = [
      ['Pull', f.held ? `${size.toFixed(2)} N by the cloth${pushed > 0.005 ? `, ${pushed.toFixed(2)} N by the body` : ''}` : 'nothing held'], ['Time', f.speed > 0.97 ? 'as it is' : `slowed to ${Math.round(100 * f.speed)} %`],
      ['A step', `${f.stepMs.toFixed(1)} ms of CPU time, ${f.contacts} contacts`], ['Fastest', `${f.fastest.toFixed(2)} m/s`], ['Pinned', `${f.pinned} vertices`]];
    if (f.status & 1) rows.push(['Trouble', 'a vertex was lost: put back']);
    this.facts.replaceChildren(...rows.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)]));
  }

  private async load(): Promise<void> {
    if (this.loading) return;
    this.loading = true;
    try {
      const data = await fetchBytes('/api/fitting');
      const head = new Uint32Array(data, 0, 5), [, number, bones, vertices, triangles] = head;
      let at = 20;
      const fresh = !this.cloth;
      this.endCut(false);  // its points were of the triangles before
      for (const m of [...this.bones, ...(this.cloth ? [this.cloth] : [])]) { this.world.extra.remove(m); m.geometry.dispose(); }
      this.bones = [];
      for (let b = 0; b < bones; ++b) {
        const [v, t] = new Uint32Array(data, at, 2), g = new THREE.BufferGeometry();
        g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(data, at + 8, 3 * v), 3));
        g.setIndex(new THREE.BufferAttribute(new Uint32Array(data, at + 8 + 12 * v, 3 * t), 1));
        g.computeVertexNormals();
        at += 8 + 12 * v + 12 * t;
        const m = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ color: 0xd9b99b, roughness: 0.8 }));
        m.matrixAutoUpdate = false;
        m.frustumCulled = false;
        this.bones.push(m);
        this.world.extra.add(m);
      }
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * vertices), 3));
      g.setIndex(new THREE.BufferAttribute(new Uint32Array(data, at, 3 * triangles).slice(), 1));
      this.cloth = new THREE.Mesh(g, new THREE.MeshStandardMaterial({ roughness: 0.85, side: THREE.DoubleSide }));
      this.cloth.frustumCulled = false;
      this.world.extra.add(this.cloth);
      this.number = number;
      this.colour();
      if (fresh) this.onReady();
    } catch { /* the next frame asks again */ } finally { this.loading = false; }
  }

  /// The cloth under the cursor, where the body does not hide it.
  private under(): THREE.Vector3 | null {
    if (!this.cloth) return null;
    this.cloth.geometry.boundingSphere = null;
    const hit = this.world.castMesh(this.cursor.x, this.cursor.y, this.cloth);
    if (!hit || hit.faceIndex == null) return null;
    const p = hit.point, share = THREE.Triangle.getBarycoord(p, ...this.corners(hit.faceIndex), new THREE.Vector3());
    this.touched = share && { triangle: hit.faceIndex, u: Math.min(Math.max(share.y, 0), 1), v: Math.min(Math.max(share.z, 0), 1) };
    const eye = this.world.camera.position, far = p.distanceTo(eye);
    for (const bone of this.bones) { const q = this.world.castMesh(this.cursor.x, this.cursor.y, bone)?.point; if (q && q.distanceTo(eye) < far - 0.01) return null; }
    return p;
  }
  private down(e: PointerEvent): void {
    if (!this.active || this.stopped() || e.button !== 0 || e.ctrlKey || e.shiftKey) return;
    this.cursor.copy(this.world.onCanvas(e));
    const p = this.under();
    if (!p && !this.cuts.checked) return;  // beside the cloth the drag turns the view
    e.stopImmediatePropagation();
    this.canvas.focus();
    this.canvas.setPointerCapture(e.pointerId);
    if (this.pins.checked) this.pin(p as THREE.Vector3);
    else if (this.cuts.checked) { this.draws = true; this.line = []; this.extend(); }  // from outside the hem as well
    else this.grasp(p as THREE.Vector3);
  }
  private pin(p: THREE.Vector3): void { if (this.touched) this.pinned.push(this.touched); this.pinnedAt = performance.now(); this.say({ say: 'cloth', do: 'pin', p: p.toArray() }); announce('Pinned.'); }
  private grasp(p: THREE.Vector3): void { this.at.copy(p); this.held = true; this.say({ say: 'cloth', do: 'grasp', p: p.toArray() }); }
  /// A line of points on the cloth, which goes where the cloth goes; draws: by the pointer, else by keys.
  private beginCut(): void { this.line = this.touched ? [this.touched] : null; this.drawLine(); }
  private extend(): void {
    const p = this.under();
    if (!p || !this.touched || !this.line || this.line.length >= MOST_LINE || (this.line.length > 0 && p.distanceTo(this.placeOf(this.line[this.line.length - 1])) < LINE_STEP)) return;
    this.line.push(this.touched);
    this.drawLine();
  }
  private corners(triangle: number): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
    const g = this.cloth!.geometry, index = g.getIndex()!, p = g.getAttribute('position') as THREE.BufferAttribute;
    const corner = (k: number) => new THREE.Vector3().fromBufferAttribute(p, index.getX(3 * triangle + k));
    return [corner(0), corner(1), corner(2)];
  }
  private placeOf(p: OnCloth): THREE.Vector3 {
    const [a, b, c] = this.corners(p.triangle);
    return a.multiplyScalar(1 - p.u - p.v).addScaledVector(b, p.u).addScaledVector(c, p.v);
  }
  private endCut(done: boolean): void {
    const line = this.line;
    this.line = null;
    this.draws = false;
    this.drawLine();
    if (!done || !line) return;
    if (line.length < 2) { announce('Nothing was cut: the line is too short.'); return; }
    this.say({ say: 'cloth', do: 'slit', line: line.map((p) => [p.triangle, Number(p.u.toFixed(4)), Number(p.v.toFixed(4))]) });
    announce('Cut along the line.');
  }
  private drawLine(): void {
    this.drawn.visible = (this.line?.length ?? 0) > 1;
    if (this.drawn.visible) { this.drawn.geometry.dispose(); this.drawn.geometry = new THREE.BufferGeometry().setFromPoints(this.line!.map((p) => this.placeOf(p))); }
    this.world.redraw();
  }
  private drag(): void { this.at.copy(this.world.beside(this.cursor.x, this.cursor.y, this.at)); this.dragged = this.at.clone(); }
  release(): void {
    if (!this.held) return;
    this.held = false;
    this.dragged = null;
    this.say({ say: 'cloth', do: 'release' });
  }

  private key(e: KeyboardEvent): void {
    if (!this.active) return;
    const step = e.shiftKey ? 0.02 : 0.06;
    const moves: Record<string, [number, number]> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const move = moves[e.key];
    if (move) {
      e.preventDefault();
      e.stopPropagation();
      this.cursor.set(Math.min(Math.max(this.cursor.x + move[0] / this.world.camera.aspect, -1), 1), Math.min(Math.max(this.cursor.y + move[1], -1), 1));
      if (this.held) this.drag();
      else if (this.line) { this.extend(); this.world.tool.mark(this.under() ?? this.placeOf(this.line[this.line.length - 1])); }
      else this.world.tool.mark(this.under() ?? this.world.beside(this.cursor.x, this.cursor.y, this.world.controls.target));
    } else if (this.stopped() && /^(c|p|Enter)$/i.test(e.key)) {
      e.preventDefault();
      announce('Stopped: nothing can be taken until you press Resume.');
    } else if (e.key === 'c' || e.key === 'C') {
      e.preventDefault();
      if (this.line) { this.endCut(true); return; }
      const p = this.under();
      if (!p) { announce('No cloth here: move the cross with the arrow keys.'); return; }
      this.draws = false;
      this.beginCut();
      announce('A cut begins here: arrow keys draw it, C cuts.');
    } else if (e.key === 'Enter' || e.key === 'p' || e.key === 'P') {
      e.preventDefault();
      if (this.held) { this.release(); announce('Let go'); return; }
      const p = this.under();
      if (!p) { announce('No cloth here: move the cross with the arrow keys.'); return; }
      if (e.key === 'Enter') { this.grasp(p); announce('Taken: arrow keys pull.'); } else this.pin(p);
    } else if (e.key === 'q' || e.key === 'e') {
      const offset = this.world.camera.position.clone().sub(this.world.controls.target);
      offset.applyAxisAngle(new THREE.Vector3(0, 1, 0), (e.key === 'q' ? 1 : -1) * (Math.PI / 12));
      this.world.camera.position.copy(this.world.controls.target).add(offset);
      this.world.camera.lookAt(this.world.controls.target);
      this.world.camera.updateMatrixWorld();
      this.world.redraw();
    }
  }
}
