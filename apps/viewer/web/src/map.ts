// A part's map unrolled: how far the surface lies below the superquadric, linked with the 3D view.
import * as THREE from 'three';
import { sequentialColour } from './colours';
import { announce, digits, h } from './dom';
import { fetchBytes } from './net';

export class MapView {
  readonly element: HTMLElement;
  private canvas = h('canvas', { class: 'map-canvas', tabIndex: 0, role: 'application', 'aria-label': 'Unrolled map of the part: six faces of a cube as a cross, bright where the surface lies deep below the superquadric. Arrow keys move the mark, with Shift farther; Enter picks the place.' });
  private words = h('p', { class: 'map-words' }, 'Select a part: click the object.');
  private width = 0;
  private height = 0;
  private data = new Float32Array(0);
  private picture: ImageData | null = null;
  private request = 0;
  private most = 1;
  private at = -1;  ///< the marked cell
  onPoint: (p: THREE.Vector3 | null) => void = () => {};
  onPick: (p: THREE.Vector3) => void = () => {};

  constructor() {
    this.element = h('div', {}, this.canvas, this.words);
    this.canvas.addEventListener('pointermove', (e) => this.hover(e));
    this.canvas.addEventListener('pointerdown', (e) => { const p = this.hover(e); if (p) this.onPick(p); });
    this.canvas.addEventListener('pointerleave', () => { this.onPoint(null); this.draw(-1); });
    this.canvas.addEventListener('keydown', (e) => this.key(e));
  }

  clear(words: string): void {
    ++this.request;
    this.width = 0;
    this.canvas.hidden = true;
    this.words.textContent = words;
  }

  async load(object: number, part: number, name: string): Promise<void> {
    const request = ++this.request;
    this.at = -1;
    const data = await fetchBytes(`/api/object/${object}/map/${part}`);
    if (request !== this.request) return;
    const [, width, height] = new Uint32Array(data, 0, 3);
    this.width = width;
    this.height = height;
    this.data = new Float32Array(data, 12);
    const hits: number[] = [];
    for (let i = 0; i < width * height; ++i) if (this.data[4 * i] >= 0) hits.push(this.data[4 * i]);
    hits.sort((a, b) => a - b);
    this.most = Math.max(hits[Math.floor(0.99 * (hits.length - 1))] ?? 1, 1e-9);
    this.canvas.width = width;
    this.canvas.height = height;
    const picture = new ImageData(width, height);
    for (let i = 0; i < width * height; ++i) {
      const d = this.data[4 * i];
      const c = d >= 0 ? sequentialColour(d / this.most) : [0.55, 0.57, 0.6];
      picture.data.set([255 * c[0], 255 * c[1], 255 * c[2], d === -3 ? 0 : 255], 4 * i);
    }
    this.picture = picture;
    this.canvas.hidden = false;
    this.words.textContent = `${name}. Dark: at the superquadric; bright: ${digits(1000 * this.most)} mm below it. Point at it, click it.`;
    this.draw(-1);
  }

  private draw(at: number): void {
    if (at >= 0) this.at = at;
    if (!this.picture || this.width === 0) return;
    const c = this.canvas.getContext('2d')!;
    c.putImageData(this.picture, 0, 0);
    if (at < 0) return;
    c.strokeStyle = '#fff';
    c.lineWidth = 3;
    const x = (at % this.width) + 0.5, y = Math.floor(at / this.width) + 0.5;
    for (const colour of ['#fff', '#d4145a']) {
      c.strokeStyle = colour;
      c.beginPath();
      c.arc(x, y, 3.5, 0, 2 * Math.PI);
      c.stroke();
      c.lineWidth = 1.4;
    }
  }

  private hover(e: PointerEvent): THREE.Vector3 | null {
    if (this.width === 0) return null;
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((e.clientX - box.left) / box.width) * this.width), y = Math.floor(((e.clientY - box.top) / box.height) * this.height);
    const i = y * this.width + x;
    if (x < 0 || y < 0 || x >= this.width || y >= this.height || !(this.data[4 * i] >= 0)) { this.onPoint(null); this.draw(-1); return null; }
    return this.point(i);
  }

  private point(i: number): THREE.Vector3 {
    this.draw(i);
    this.words.textContent = `${digits(1000 * this.data[4 * i])} mm below the superquadric`;
    const p = new THREE.Vector3(this.data[4 * i + 1], this.data[4 * i + 2], this.data[4 * i + 3]);
    this.onPoint(p);
    return p;
  }

  /// Cells without a surface are passed over.
  private key(e: KeyboardEvent): void {
    const moves: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -this.width, ArrowDown: this.width };
    const move = moves[e.key], there = (i: number) => this.data[4 * i] >= 0;
    if (this.width === 0 || (move === undefined && e.key !== 'Enter')) return;
    e.preventDefault();
    const cells = this.width * this.height;
    if (this.at < 0 || this.at >= cells || !there(this.at)) this.at = this.data.findIndex((d, k) => k % 4 === 0 && d >= 0) / 4;
    if (this.at < 0) return;
    if (move !== undefined) {
      const row = Math.floor(this.at / this.width);
      let left = e.shiftKey ? 6 : 1, next = this.at;
      for (let i = this.at + move; left > 0 && i >= 0 && i < cells && (Math.abs(move) > 1 || Math.floor(i / this.width) === row); i += move)
        if (there(i)) { next = i; --left; }
      this.at = next;
    }
    const p = this.point(this.at);
    announce(this.words.textContent ?? '');
    if (e.key === 'Enter') this.onPick(p);
  }

  /// Marks the place of a surface point; false where the map does not show it.
  show(p: THREE.Vector3): boolean {
    let best = -1, least = Infinity;
    for (let i = 0; i < this.width * this.height; ++i) {
      if (!(this.data[4 * i] >= 0)) continue;
      const dx = this.data[4 * i + 1] - p.x, dy = this.data[4 * i + 2] - p.y, dz = this.data[4 * i + 3] - p.z, d = dx * dx + dy * dy + dz * dz;
      if (d < least) { least = d; best = i; }
    }
    if (best < 0) return false;
    this.draw(best);
    this.words.textContent = `${digits(1000 * this.data[4 * best])} mm below the superquadric`;
    return true;
  }
}
