// The costume designer's view: a figure that the program dresses, and hands that pull and pin its cloth.
import * as THREE from 'three';
import { GLTFExporter } from 'three/examples/jsm/exporters/GLTFExporter.js';
import { announce, fill, h } from '../dom';
import { showTag } from '../felt';
import { Figure } from '../figure';
import { geometryOf, vector } from '../geometry';
import { ClothMarks, onCloth, type OnCloth } from '../cloth_marks';
import type { ClothFrame } from '../messages';
import { fetchBytes, link, program } from '../net';
import { trouble } from '../notices';
import { canvas, hint, showHint, world } from '../stage';
import { on, state } from '../state';
import { onStop, whileFelt } from '../stop';
import { card } from './controls';

const GARMENTS: [string, string][] = [
  ['shirt', 'Shirt'],
  ['skirt', 'Skirt'],
  ['poncho', 'Poncho'],
];
const FABRICS: [string, string, number][] = [
  ['cotton', 'Cotton', 0x3b6ea5],
  ['silk', 'Silk', 0xb08ad0],
  ['denim', 'Denim', 0x2b4a78],
  ['wool', 'Wool', 0xb5563c],
  ['leather', 'Leather', 0x6b4a32],
];

class Costume {
  readonly element: HTMLElement;
  private garment = h(
    'select',
    { id: 'garment', onchange: () => this.fit() },
    ...GARMENTS.map(([v, t]) => h('option', { value: v }, t)),
  );
  private fabric = h(
    'select',
    { id: 'fabric', onchange: () => this.fit() },
    ...FABRICS.map(([v, t]) => h('option', { value: v }, t)),
  );
  private walks = h('input', { type: 'checkbox', id: 'walks', onchange: () => this.fit() });
  private pins = h('input', { type: 'radio', name: 'grip', id: 'grip-pin' });
  private cuts = h('input', { type: 'radio', name: 'grip', id: 'grip-cut' });
  private pulls = h('input', { type: 'radio', name: 'grip', id: 'grip-pull', checked: true });
  private avatarInput = h('input', {
    type: 'file',
    id: 'avatar-file',
    hidden: true,
    'aria-label': 'Own figure: a skinned glTF file',
    accept: '.glb,.gltf',
    onchange: () => {
      const file = this.avatarInput.files?.[0];
      this.avatarInput.value = '';
      if (file) void this.wear(file, file.name);
    },
  });
  private plain = h(
    'button',
    { id: 'plain-figure', hidden: true, onclick: () => void this.wear(new Blob([]), '') },
    'The first figure',
  );
  private seams = h('div', { class: 'row wrap', role: 'group', 'aria-label': 'Seams' });
  private facts = h('dl', { class: 'numbers', id: 'cloth-facts' });
  private figure: Figure | null = null;
  private cloth: THREE.Mesh | null = null;
  private number = -1;
  private loading = false;
  private at = new THREE.Vector3();
  private cursor = new THREE.Vector2();
  private dragged: THREE.Vector3 | null = null;
  private marks = new ClothMarks(() => this.cloth);
  private touched: OnCloth | null = null; ///< the point that under() found last
  private draws = false; ///< a cut, with the pointer
  private seamText = '';
  private factsDue = 0;
  held = false;
  active = false;
  frames = 0;
  last: ClothFrame | null = null;

  constructor() {
    const radio = (input: HTMLInputElement, text: string) => h('label', { class: 'check' }, input, h('span', {}, text));
    this.element = h(
      'div',
      {},
      h('label', { class: 'field' }, h('span', {}, 'Garment'), this.garment),
      h('label', { class: 'field' }, h('span', {}, 'Fabric'), this.fabric),
      h('label', { class: 'check' }, this.walks, h('span', {}, 'The figure walks')),
      h(
        'fieldset',
        {},
        h('legend', {}, 'A press on the cloth'),
        radio(this.pulls, 'takes it and pulls'),
        radio(this.pins, 'pins it to the body, or to the air where the body is far'),
        radio(this.cuts, 'cuts it along the drag'),
      ),
      this.seams,
      h(
        'div',
        { class: 'row wrap' },
        h(
          'button',
          {
            id: 'unpin',
            onclick: () => {
              link.say({ say: 'cloth', do: 'unpin' });
              announce('Pins taken out.');
            },
          },
          'Take pins out',
        ),
        h('button', { id: 'own-avatar', onclick: () => this.avatarInput.click() }, 'Own figure …'),
        this.plain,
        this.avatarInput,
        h(
          'button',
          {
            id: 'dress-again',
            onclick: () => {
              link.say({ say: 'cloth', do: 'restart' });
              announce('Dressed anew.');
            },
          },
          'Start again',
        ),
      ),
      this.facts,
      h(
        'p',
        { class: 'note' },
        'Keys on the stage: arrows move the cross, Enter takes and lets go, P pins, C begins a cut and ends it, Q and E walk round.',
      ),
    );
    world.extra.visible = false;
    canvas.addEventListener('pointerdown', (e) => this.down(e), { capture: true });
    canvas.addEventListener('pointermove', (e) => {
      if (!this.active) return;
      if (this.held) {
        this.cursor.copy(world.onCanvas(e));
        this.drag();
      } else if (this.draws) {
        this.cursor.copy(world.onCanvas(e));
        this.extend();
      }
    });
    for (const type of ['pointerup', 'pointercancel'] as const)
      canvas.addEventListener(type, () => {
        if (this.draws) this.endCut(type === 'pointerup');
        this.release();
      });
    canvas.addEventListener('keydown', (e) => this.key(e));
  }

  enter(): void {
    this.active = true;
    this.number = -1; // the next figure is fetched, whatever its number
    world.extra.visible = true;
    world.groundAt(0);
    world.frameBox(new THREE.Box3(new THREE.Vector3(-0.75, 0, -0.3), new THREE.Vector3(0.75, 1.75, 0.3)));
    this.fit();
  }
  leave(): void {
    if (!this.active) return;
    this.active = false;
    this.release();
    this.endCut(false);
    world.tool.showArrow(null);
    world.extra.visible = false;
    world.hideFigureShadow();
    world.groundUnder();
    link.say({ say: 'undress' });
  }
  /// Dresses the figure again after a lost connection: the program has forgotten it.
  again(): void {
    this.held = false;
    if (this.active) this.fit();
  }

  /// The choices for a link to this view; choose() restores them.
  chosen(): unknown[] {
    return [this.garment.value, this.fabric.value, this.walks.checked];
  }
  choose([garment, fabric, walks]: unknown[]): void {
    if (GARMENTS.some(([g]) => g === garment)) this.garment.value = String(garment);
    if (FABRICS.some(([f]) => f === fabric)) this.fabric.value = String(fabric);
    this.walks.checked = walks === true;
  }

  /// The figure and what it wears, as they stand now.
  async glb(): Promise<ArrayBuffer | null> {
    if (!this.cloth) return null;
    const group = new THREE.Group();
    for (const mesh of [this.figure!.mesh, this.cloth]) {
      const copy = mesh.clone(false);
      copy.name = mesh === this.cloth ? this.garment.value : 'figure';
      group.add(copy);
    }
    return (await new GLTFExporter().parseAsync(group, { binary: true })) as ArrayBuffer;
  }

  /// Another figure: a closed mesh with joints, standing, in metres, y up; without a name the page's own. It is baked first.
  private async wear(file: Blob, name: string): Promise<void> {
    try {
      const { status, text } = await program.post(
        `/api/avatar?name=${encodeURIComponent(name)}`,
        file,
        () => {},
        new AbortController().signal,
      );
      if (status !== 200) throw new Error(text.trim());
      this.plain.hidden = name === '';
      showHint('The figure is being prepared: some seconds.');
      this.fit();
    } catch (e) {
      trouble(`${name}: ${e instanceof Error ? e.message : e}`);
    }
  }
  private fit(): void {
    link.say({ say: 'fit', garment: this.garment.value, fabric: this.fabric.value, walks: this.walks.checked });
    this.colour();
  }
  private colour(): void {
    const found = FABRICS.find(([name]) => name === this.fabric.value);
    if (this.cloth && found) {
      (this.cloth.material as THREE.MeshStandardMaterial).color.set(found[2]);
      world.redraw();
    }
  }

  status(): void {
    const seams = state.status?.cloth.worn?.seams ?? [],
      text = JSON.stringify(seams);
    if (text === this.seamText) return;
    this.seamText = text;
    fill(
      this.seams,
      ...seams.map((seam, i) =>
        h(
          'button',
          {
            id: `seam-${seam.name.replaceAll(' ', '-')}`,
            'aria-pressed': String(!seam.sewn),
            onclick: () => {
              link.say({ say: 'cloth', do: seam.sewn ? 'cut' : 'sew', seam: i });
              announce(`${seam.name}: ${seam.sewn ? 'opened' : 'sewn'}.`);
            },
          },
          `${seam.sewn ? 'Open' : 'Sew'} the ${seam.name}`,
        ),
      ),
    );
  }

  frame(f: ClothFrame): void {
    if (!this.active) return;
    if (f.number !== this.number) {
      void this.load();
      return;
    }
    if (!this.cloth || this.cloth.geometry.getAttribute('position').count * 3 !== f.positions.length) return;
    ++this.frames;
    this.last = f;
    this.figure?.pose(f.poses);
    const attribute = this.cloth.geometry.getAttribute('position') as THREE.BufferAttribute;
    (attribute.array as Float32Array).set(f.positions);
    attribute.needsUpdate = true;
    this.cloth.geometry.computeVertexNormals();
    this.marks.follow(f.pinned);
    // The hand feels one force, of the cloth and of the body: one arrow, one number.
    const pull = vector(f.tension).add(vector(f.body)),
      size = pull.length();
    world.tool.showArrow(f.held ? this.at : null, pull, 3);
    showTag(size, this.at);
    if (this.figure) world.shadeFigure([this.figure.mesh, this.cloth]);
    world.redraw();
    if (performance.now() < this.factsDue) return;
    this.factsDue = performance.now() + 250;
    const rows: [string, string][] = [
      [
        'Pull',
        f.held ? `${size.toFixed(1)} N${Math.hypot(...f.tension) > 29.9 ? ', the most a hand pulls here' : ''}` : 'nothing held',
      ],
      [
        'Time',
        f.speed > 0.97 ? 'as it is' : `slowed to ${Math.round(100 * f.speed)} %: the cloth costs more than this computer has`,
      ],
      ['A step', `${f.stepMs.toFixed(1)} ms of CPU time, ${f.contacts} contacts`],
      ['Fastest', `${f.fastest.toFixed(2)} m/s`],
      ['Pinned', `${f.pinned} vertices`],
    ];
    if (f.status & 1) rows.push(['Trouble', 'a vertex was lost: put back']);
    this.facts.replaceChildren(...rows.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)]));
  }

  private ready(): void {
    showHint('Press on the cloth and drag: it is pulled. Beside it the drag turns the view.');
    setTimeout(() => {
      if (state.mode === 'dress') hint.hidden = true;
    }, 6000);
  }
  private async load(): Promise<void> {
    if (this.loading) return;
    this.loading = true;
    try {
      const data = await fetchBytes('/api/fitting');
      const [, number, , vertices, triangles, skinVertices, skinTriangles] = new Uint32Array(data, 0, 7);
      const fresh = !this.cloth;
      this.endCut(false); // the cut's points were on the triangles of the old cloth
      for (const m of [this.figure?.mesh, this.cloth])
        if (m) {
          world.extra.remove(m);
          m.geometry.dispose();
        }
      this.figure = new Figure(data, 28, skinVertices, skinTriangles);
      world.extra.add(this.figure.mesh);
      const at = 28 + 44 * skinVertices + 12 * skinTriangles;
      this.cloth = new THREE.Mesh(
        geometryOf(new Float32Array(3 * vertices), new Uint32Array(data, at, 3 * triangles).slice()),
        new THREE.MeshStandardMaterial({ roughness: 0.85, side: THREE.DoubleSide }),
      );
      this.cloth.frustumCulled = false;
      world.extra.add(this.cloth);
      this.number = number;
      this.colour();
      if (fresh) this.ready();
    } catch {
      /* the next frame asks again */
    } finally {
      this.loading = false;
    }
  }

  /// The cloth under the cursor, where the body does not hide it.
  private under(): THREE.Vector3 | null {
    if (!this.cloth) return null;
    this.cloth.geometry.boundingSphere = null;
    const hit = world.castMesh(this.cursor.x, this.cursor.y, this.cloth);
    if (!hit || hit.faceIndex == null) return null;
    const p = hit.point;
    this.touched = onCloth(this.cloth, hit.faceIndex, p);
    const eye = world.camera.position,
      far = p.distanceTo(eye);
    const q = this.figure && world.castMesh(this.cursor.x, this.cursor.y, this.figure.mesh)?.point;
    if (q && q.distanceTo(eye) < far - 0.01) return null;
    return p;
  }
  private down(e: PointerEvent): void {
    if (!this.active || state.status?.stopped || e.button !== 0 || e.ctrlKey || e.shiftKey) return;
    this.cursor.copy(world.onCanvas(e));
    const p = this.under();
    if (!p && !this.cuts.checked) return; // beside the cloth the drag turns the view
    e.stopImmediatePropagation();
    canvas.focus();
    canvas.setPointerCapture(e.pointerId);
    if (this.pins.checked) this.pin(p as THREE.Vector3);
    else if (this.cuts.checked) {
      this.draws = true;
      this.marks.begin();
      this.extend();
    } // from outside the hem as well
    else this.grasp(p as THREE.Vector3);
  }
  private pin(p: THREE.Vector3): void {
    if (this.touched) this.marks.pin(this.touched);
    link.say({ say: 'cloth', do: 'pin', p: p.toArray() });
    announce('Pinned.');
  }
  private grasp(p: THREE.Vector3): void {
    this.at.copy(p);
    this.held = true;
    link.say({ say: 'cloth', do: 'grasp', p: p.toArray() });
  }
  private extend(): void {
    if (this.under() && this.touched) this.marks.extend(this.touched);
  }
  private endCut(done: boolean): void {
    const line = this.marks.end();
    this.draws = false;
    if (!done || !line) return;
    if (line.length < 2) {
      announce('Nothing was cut: the line is too short.');
      return;
    }
    link.say({ say: 'cloth', do: 'slit', line: line.map((p) => [p.triangle, Number(p.u.toFixed(4)), Number(p.v.toFixed(4))]) });
    announce('Cut along the line.');
  }
  private drag(): void {
    this.at.copy(world.beside(this.cursor.x, this.cursor.y, this.at));
    this.dragged = this.at.clone();
    this.dragDue ||= window.setTimeout(() => this.sayDrag(), 16);
  }
  private dragDue = 0;
  private sayDrag(): void {
    this.dragDue = 0;
    if (this.dragged) link.say({ say: 'cloth', do: 'drag', p: this.dragged.toArray().map((x) => Number(x.toFixed(5))) });
    this.dragged = null;
  }
  release(): void {
    if (!this.held) return;
    this.held = false;
    this.dragged = null;
    link.say({ say: 'cloth', do: 'release' });
  }

  private key(e: KeyboardEvent): void {
    if (!this.active) return;
    const step = e.shiftKey ? 0.02 : 0.06;
    const moves: Record<string, [number, number]> = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, step],
      ArrowDown: [0, -step],
    };
    const move = moves[e.key];
    if (move) {
      e.preventDefault();
      e.stopPropagation();
      this.cursor.set(
        Math.min(Math.max(this.cursor.x + move[0] / world.camera.aspect, -1), 1),
        Math.min(Math.max(this.cursor.y + move[1], -1), 1),
      );
      if (this.held) this.drag();
      else if (this.marks.tip) {
        this.extend();
        world.tool.mark(this.under() ?? this.marks.tip);
      } else world.tool.mark(this.under() ?? world.beside(this.cursor.x, this.cursor.y, world.controls.target));
    } else if (state.status?.stopped && /^(c|p|Enter)$/i.test(e.key)) {
      e.preventDefault();
      announce('Stopped: nothing can be taken until you press Resume.');
    } else if (e.key === 'c' || e.key === 'C') {
      e.preventDefault();
      if (this.marks.tip) {
        this.endCut(true);
        return;
      }
      const p = this.under();
      if (!p) {
        announce('No cloth here: move the cross with the arrow keys.');
        return;
      }
      this.draws = false;
      this.marks.begin();
      this.extend();
      announce('A cut begins here: arrow keys draw it, C cuts.');
    } else if (e.key === 'Enter' || e.key === 'p' || e.key === 'P') {
      e.preventDefault();
      if (this.held) {
        this.release();
        announce('Let go');
        return;
      }
      const p = this.under();
      if (!p) {
        announce('No cloth here: move the cross with the arrow keys.');
        return;
      }
      if (e.key === 'Enter') {
        this.grasp(p);
        announce('Taken: arrow keys pull.');
      } else this.pin(p);
    } else if (e.key === 'q' || e.key === 'e') {
      world.walk(e.key);
    }
  }
}

export const costume = new Costume();
export const dressPanel = h('div', {}, card('Costume', costume.element));
onStop(() => costume.release());
whileFelt(() => costume.held);
on(['status'], () => costume.status());
