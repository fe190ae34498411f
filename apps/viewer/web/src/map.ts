// A part's map unrolled: how far the surface lies below the superquadric, linked with the 3D view. Feet of contacts and steps of
// a search are drawn over it.
import type * as THREE from 'three';
import { greyColour, sequentialColour, type Rgb } from './colours';
import { announce, digits, h } from './dom';
import { vector } from './geometry';
import { fetchBytes } from './net';
import { cleared, disc, dot } from './paint2d';

/// A position on the picture: shares of its width and height, from the upper left.
interface MapPlace {
  x: number;
  y: number;
}
interface MapFoot extends MapPlace {
  depth: number;
}
/// stride: samples between neighbours of its level; best: the level ended here.
interface MapStep extends MapPlace {
  stride: number;
  best: boolean;
}

const MARK = '#d4145a',
  FOOT = '#ff3d2e',
  NO_SURFACE = -1,
  CAP = -2,
  PAPER = -3;
const CAP_COLOUR: Rgb = [0.71, 0.4, 0.17];

/// Distances and points of one part's map, as the program sends them.
interface MapData {
  width: number;
  height: number;
  cells: Float32Array;
  most: number;
}

function readMap(data: ArrayBuffer): MapData {
  const [, width, height] = new Uint32Array(data, 0, 3),
    cells = new Float32Array(data, 12),
    hits: number[] = [];
  for (let i = 0; i < width * height; ++i) if (cells[4 * i] >= 0) hits.push(cells[4 * i]);
  hits.sort((a, b) => a - b);
  return { width, height, cells, most: Math.max(hits[Math.floor(0.99 * (hits.length - 1))] ?? 1, 1e-9) };
}

export class MapView {
  readonly element: HTMLElement;
  private canvas = h('canvas', {
    class: 'map-canvas',
    tabIndex: 0,
    role: 'application',
    'aria-label':
      'Map of the part: bright where the surface lies deep below the superquadric. Arrow keys move the mark, with Shift farther; Enter picks the point.',
  });
  private words = h('p', { class: 'map-words' }, 'Select a part: click the object.');
  private map: MapData | null = null;
  private picture = document.createElement('canvas');
  private known = new Map<string, MapData>();
  private request = 0;
  private shown = '';
  private name = '';
  private end = '';
  private at = -1; ///< the marked cell
  private marked = false;
  private feet: MapFoot[] = [];
  private steps: MapStep[] = [];
  private grey = false;
  onPoint: (p: THREE.Vector3 | null) => void = () => {};
  onPick: (p: THREE.Vector3) => void = () => {};

  constructor() {
    this.element = h('div', {}, this.canvas, this.words);
    this.canvas.addEventListener('pointermove', (e) => this.hover(e));
    this.canvas.addEventListener('pointerdown', (e) => {
      const p = this.hover(e);
      if (p) this.onPick(p);
    });
    this.canvas.addEventListener('pointerleave', () => {
      this.onPoint(null);
      this.draw(-1);
    });
    this.canvas.addEventListener('keydown', (e) => this.key(e));
    new ResizeObserver(() => this.draw(this.marked ? this.at : -1)).observe(this.element);
  }

  clear(words: string): void {
    ++this.request;
    this.map = null;
    this.shown = '';
    this.canvas.hidden = true;
    this.words.textContent = words;
  }

  /// Loads and shows a part's map. revision: the maps of one revision never change. end: the last words below the map.
  async load(object: number, part: number, revision: string, [name, end]: [string, string]): Promise<void> {
    const request = ++this.request,
      key = `${revision}/${part}`;
    if (key === this.shown) return;
    let map = this.known.get(key);
    if (!map) {
      map = readMap(await fetchBytes(`/api/object/${object}/map/${part}`));
      if (this.known.size >= 64) this.known.clear();
      this.known.set(key, map);
    }
    if (request !== this.request) return;
    this.shown = key;
    this.at = -1;
    this.map = map;
    this.feet = [];
    this.name = name;
    this.end = end;
    this.paint();
    this.say();
  }

  private say(): void {
    const map = this.map;
    if (!map) return;
    let none = false,
      cap = false;
    for (let i = 0; i < map.width * map.height; ++i) {
      none ||= map.cells[4 * i] === NO_SURFACE;
      cap ||= map.cells[4 * i] === CAP;
    }
    this.words.textContent = `${this.name}. ${this.grey ? 'Black' : 'Dark'}: at the superquadric; ${this.grey ? 'white' : 'bright'}: ${digits(1000 * map.most)} mm below it${none ? `; ${this.grey ? 'blue' : 'grey'}: no surface on this ray` : ''}${cap ? '; brown: the ray starts inside the solid' : ''}. ${this.end}`;
  }

  /// Draws the map in grey, white for far, as Fig. 4c has it; or in colours.
  setGrey(grey: boolean): void {
    this.grey = grey;
    this.paint();
    this.say();
  }

  setFeet(feet: MapFoot[]): void {
    this.feet = feet;
    this.draw(-1);
  }
  setSteps(steps: MapStep[]): void {
    this.steps = steps;
    this.draw(this.marked ? this.at : -1);
  }
  /// For tests: what is drawn over the map.
  over(): { part: string; feet: MapFoot[]; steps: MapStep[] } {
    return { part: this.shown, feet: this.map ? this.feet : [], steps: this.map ? this.steps : [] };
  }

  private paint(): void {
    const map = this.map;
    if (!map) return;
    this.picture.width = map.width;
    this.picture.height = map.height;
    const image = new ImageData(map.width, map.height),
      none: Rgb = this.grey ? [0.24, 0.35, 0.5] : [0.55, 0.57, 0.6];
    for (let i = 0; i < map.width * map.height; ++i) {
      const d = map.cells[4 * i];
      const c = d >= 0 ? (this.grey ? greyColour : sequentialColour)(d / map.most) : d === CAP ? CAP_COLOUR : none;
      image.data.set([255 * c[0], 255 * c[1], 255 * c[2], d === PAPER ? 0 : 255], 4 * i);
    }
    this.picture.getContext('2d')!.putImageData(image, 0, 0);
    this.canvas.hidden = false;
    this.draw(-1);
  }

  private draw(at: number): void {
    if (at >= 0) this.at = at;
    this.marked = at >= 0;
    const map = this.map,
      wide = this.canvas.clientWidth;
    if (!map || wide === 0) return;
    const high = (wide * map.height) / map.width,
      c = cleared(this.canvas, wide, high);
    c.imageSmoothingEnabled = false;
    c.drawImage(this.picture, 0, 0, wide, high);
    this.drawSteps(c, wide, high);
    // All feet have one white rim together, because hundreds lie close.
    for (const [rim, colour] of [
      [1.5, '#fff'],
      [0, FOOT],
    ] as const)
      for (const f of this.feet) disc(c, f.x * wide, f.y * high, rim + 1 + Math.min(700 * f.depth, 2), colour);
    if (at >= 0)
      ring(c, ((at % map.width) + 0.5) * (wide / map.width), (Math.floor(at / map.width) + 0.5) * (high / map.height), 7);
  }

  /// Draws the samples of a search as dots, smaller where the level is finer. A line joins the samples where levels ended; it breaks
  /// where it would cross the map's left and right edge.
  private drawSteps(c: CanvasRenderingContext2D, wide: number, high: number): void {
    for (const s of this.steps)
      if (!s.best) dot(c, s.x * wide, s.y * high, 1.2 + 0.5 * Math.log2(1 + s.stride), '#ffffff', '#000', 0.8);
    const path = this.steps.filter((s) => s.best);
    for (const [width, colour] of [
      [4, '#000'],
      [2, '#ffe600'],
    ] as const) {
      c.lineWidth = width;
      c.strokeStyle = colour;
      c.beginPath();
      path.forEach((s, i) => {
        if (i === 0 || Math.abs(s.x - path[i - 1].x) > 0.5) c.moveTo(s.x * wide, s.y * high);
        else c.lineTo(s.x * wide, s.y * high);
      });
      c.stroke();
    }
    for (const s of path) dot(c, s.x * wide, s.y * high, 2.6, '#ffe600', '#000', 0.8);
    const last = path.at(-1);
    if (last) ring(c, last.x * wide, last.y * high, 6);
  }

  private hover(e: PointerEvent): THREE.Vector3 | null {
    const map = this.map;
    if (!map) return null;
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((e.clientX - box.left) / box.width) * map.width),
      y = Math.floor(((e.clientY - box.top) / box.height) * map.height);
    const i = y * map.width + x;
    if (x < 0 || y < 0 || x >= map.width || y >= map.height || !(map.cells[4 * i] >= 0)) {
      this.onPoint(null);
      this.draw(-1);
      return null;
    }
    return this.point(map, i);
  }

  private point(map: MapData, i: number): THREE.Vector3 {
    this.draw(i);
    this.words.textContent = `${digits(1000 * map.cells[4 * i])} mm below the superquadric`;
    const p = vector(map.cells, 4 * i + 1);
    this.onPoint(p);
    return p;
  }

  /// Moves the mark by the arrow keys, over the cells that have a surface; Enter picks the point.
  private key(e: KeyboardEvent): void {
    const map = this.map;
    if (!map) return;
    const moves: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -map.width, ArrowDown: map.width };
    const move = moves[e.key],
      there = (i: number) => map.cells[4 * i] >= 0;
    if (move === undefined && e.key !== 'Enter') return;
    e.preventDefault();
    const cells = map.width * map.height;
    if (this.at < 0 || this.at >= cells || !there(this.at)) this.at = map.cells.findIndex((d, k) => k % 4 === 0 && d >= 0) / 4;
    if (this.at < 0) return;
    if (move !== undefined) {
      const row = Math.floor(this.at / map.width);
      let left = e.shiftKey ? 6 : 1,
        next = this.at;
      for (
        let i = this.at + move;
        left > 0 && i >= 0 && i < cells && (Math.abs(move) > 1 || Math.floor(i / map.width) === row);
        i += move
      )
        if (there(i)) {
          next = i;
          --left;
        }
      this.at = next;
    }
    const p = this.point(map, this.at);
    announce(this.words.textContent ?? '');
    if (e.key === 'Enter') this.onPick(p);
  }

  /// Marks the position of a surface point; false where the map does not show it.
  show(p: THREE.Vector3): boolean {
    const map = this.map;
    if (!map) return false;
    let best = -1,
      least = Infinity;
    for (let i = 0; i < map.width * map.height; ++i) {
      if (!(map.cells[4 * i] >= 0)) continue;
      const d = vector(map.cells, 4 * i + 1).distanceToSquared(p);
      if (d < least) {
        least = d;
        best = i;
      }
    }
    if (best < 0) return false;
    this.draw(best);
    this.words.textContent = `${digits(1000 * map.cells[4 * best])} mm below the superquadric`;
    return true;
  }
}

function ring(c: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
  for (const [width, colour] of [
    [4, '#fff'],
    [2, MARK],
  ] as const) {
    c.lineWidth = width;
    c.strokeStyle = colour;
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    c.stroke();
  }
}
