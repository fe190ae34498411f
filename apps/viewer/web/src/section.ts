// A section through an object: the level sets of a part's inside-outside function F (eqs. 1 and 2) about the cut surface.
import type * as THREE from 'three';
import { css, sequentialColour, type Rgb } from './colours';
import { h } from './dom';
import { vector } from './geometry';
import { dot, cleared } from './paint2d';

const LEVELS: [number, string][] = [
  [1 / 16, '1/16'],
  [1 / 4, '1/4'],
  [1, '1'],
  [4, '4'],
  [16, '16'],
];

export interface Section {
  corner: THREE.Vector3;
  along: THREE.Vector3;
  up: THREE.Vector3; ///< world, m
  levels: { level: number; colour: Rgb; segments: number[] }[];
  others: number[]; ///< F = 1 of the other parts
  cuts: { part: number; ends: number[] }[];
}

/// Level sets of a function on a square grid, by marching squares. Returns segments, four numbers each: x and y of both ends, from 0 to 1, y along the rows. values: side by side numbers, x fastest.
function levelSet(values: Float32Array, side: number, level: number): number[] {
  const out: number[] = [],
    step = 1 / (side - 1);
  // F grows with high powers: on its logarithm the crossing between two points is nearer to the truth.
  const v = Float32Array.from(values, (x) => Math.log(Math.max(x, 1e-12) / level));
  for (let y = 0; y + 1 < side; ++y)
    for (let x = 0; x + 1 < side; ++x) {
      const i = y * side + x,
        corners: [number, number, number][] = [
          [x, y, v[i]],
          [x + 1, y, v[i + 1]],
          [x + 1, y + 1, v[i + side + 1]],
          [x, y + 1, v[i + side]],
        ],
        ends: number[] = [];
      for (let k = 0; k < 4; ++k) {
        const [ax, ay, a] = corners[k],
          [bx, by, b] = corners[(k + 1) % 4];
        if (a < 0 === b < 0) continue;
        const t = a / (a - b);
        ends.push(step * (ax + t * (bx - ax)), step * (ay + t * (by - ay)));
      }
      // At a saddle four ends meet the cell's border; neighbours belong together.
      for (let k = 0; k + 3 < ends.length; k += 4) out.push(...ends.slice(k, k + 4));
    }
  return out;
}

export function readSection(data: ArrayBuffer): Section {
  const [, side, count] = new Uint32Array(data, 0, 3),
    head = new Float32Array(data, 12, 9),
    n = side * side;
  const own = new Float32Array(data, 48, n),
    beside = new Float32Array(data, 48 + 4 * n, n),
    rest = 48 + 8 * n;
  const words = new Uint32Array(data, rest, 5 * count),
    numbers = new Float32Array(data, rest, 5 * count);
  return {
    corner: vector(head),
    along: vector(head, 3),
    up: vector(head, 6),
    levels: LEVELS.map(([level], i) => ({
      level,
      colour: sequentialColour(0.08 + (0.8 * i) / (LEVELS.length - 1)),
      segments: levelSet(own, side, level),
    })),
    others: levelSet(beside, side, 1),
    cuts: Array.from({ length: count }, (_, i) => ({
      part: words[5 * i],
      ends: Array.from(numbers.subarray(5 * i + 1, 5 * i + 5)),
    })),
  };
}

/// The position of a point on a section, as shares of the section's edges.
const onSection = (s: Section, p: THREE.Vector3): [number, number] => {
  const d = p.clone().sub(s.corner);
  return [d.dot(s.along) / s.along.lengthSq(), d.dot(s.up) / s.up.lengthSq()];
};

export class SectionView {
  readonly canvas = h('canvas', {
    class: 'section-canvas',
    role: 'img',
    'aria-label': 'Section through the object with the level sets of F',
  });
  private section: Section | null = null;
  private part = -1;
  private point: THREE.Vector3 | null = null;
  private foot: THREE.Vector3 | null = null;

  colour: (part: number) => Rgb = () => [0.5, 0.5, 0.5]; ///< a part's colour

  constructor() {
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  show(section: Section | null, part: number, point: THREE.Vector3 | null): void {
    this.section = section;
    this.part = part;
    this.point = point;
    this.canvas.hidden = !section;
    this.draw();
  }
  setFoot(foot: THREE.Vector3 | null): void {
    this.foot = foot;
    this.draw();
  }

  draw(): void {
    const s = this.section,
      wide = this.canvas.clientWidth;
    if (!s || wide === 0) return;
    const c = cleared(this.canvas, wide, wide),
      style = getComputedStyle(document.documentElement);
    const x = (t: number) => t * wide,
      y = (t: number) => (1 - t) * wide;
    const lines = (segments: number[], colour: string, width: number, dash: number[] = []) => {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.setLineDash(dash);
      c.beginPath();
      for (let i = 0; i < segments.length; i += 4) {
        c.moveTo(x(segments[i]), y(segments[i + 1]));
        c.lineTo(x(segments[i + 2]), y(segments[i + 3]));
      }
      c.stroke();
      c.setLineDash([]);
    };
    lines(s.others, style.getPropertyValue('--soft').trim(), 1, [4, 4]);
    for (const { level, colour, segments } of s.levels) lines(segments, css(colour), level === 1 ? 3 : 1.6);
    for (const cut of s.cuts)
      lines(
        cut.ends,
        cut.part === this.part ? style.getPropertyValue('--ink').trim() : css(this.colour(cut.part)),
        cut.part === this.part ? 2 : 1.4,
      );
    c.font = '600 12px system-ui';
    for (const [i, { colour, segments }] of s.levels.entries()) {
      // Each label stands at the rightmost point of its line, where the lines are farthest apart; the labels do not meet there.
      let at = -1;
      for (let k = 0; k < segments.length; k += 4)
        if (at < 0 || segments[k] + 0.4 * segments[k + 1] > segments[at] + 0.4 * segments[at + 1]) at = k;
      if (at < 0) continue;
      const text = LEVELS[i][1],
        tx = Math.min(x(segments[at]) + 3, wide - c.measureText(text).width - 3),
        ty = Math.max(y(segments[at + 1]) - 3, 12);
      c.lineWidth = 3.5;
      c.strokeStyle = style.getPropertyValue('--card').trim();
      c.strokeText(text, tx, ty);
      c.fillStyle = css(colour.map((v) => 0.75 * v) as Rgb);
      c.fillText(text, tx, ty);
    }
    if (!this.point) return;
    const [px, py] = onSection(s, this.point);
    if (this.foot) {
      const [fx, fy] = onSection(s, this.foot);
      lines([px, py, fx, fy], '#d4145a', 1.6, [5, 3]);
      dot(c, x(fx), y(fy), 4, '#ffe600', '#fff', 1.2);
    }
    dot(c, x(px), y(py), 4.5, '#d4145a', '#fff', 1.2);
  }
}
