// Complete contacts of the objects as they stand: coloured by kind, listed by region.
import * as THREE from 'three';
import { digits, fill, h } from '../dom';
import { vector } from '../geometry';
import { fetchJson } from '../net';
import { trouble } from '../notices';
import { world } from '../stage';
import { on, state } from '../state';
import { card, check } from './controls';

/// Kind (0 to 2), region of the pair or -1, the witness points on a (2 to 4) and on b (5 to 7) in the world, depth (8); m.
type Contact = number[];
interface Pair {
  a: number;
  b: number;
  meetings: number;
  found: number;
  contacts: Contact[];
}
interface Meetings {
  pairs: Pair[];
  open: number[];
}

/// Each kind has a colour and a shape, so that people who do not see colours tell them apart.
const KINDS = [
  { name: 'vertex', colour: '#b05a00', shape: '●' },
  { name: 'edge', colour: '#0b62c4', shape: '▲' },
  { name: 'face', colour: '#c2187e', shape: '■' },
];
const LINE = 0x222222,
  PALE = 0.15;

function picture(shape: string, colour: string): THREE.CanvasTexture {
  const canvas = document.createElement('canvas'),
    c = canvas.getContext('2d')!;
  canvas.width = canvas.height = 32;
  c.fillStyle = colour;
  c.strokeStyle = '#fff';
  c.lineWidth = 3;
  c.beginPath();
  if (shape === '●') c.arc(16, 16, 12, 0, 2 * Math.PI);
  else if (shape === '▲') {
    c.moveTo(16, 3);
    c.lineTo(30, 28);
    c.lineTo(2, 28);
    c.closePath();
  } else c.rect(5, 5, 22, 22);
  c.fill();
  c.stroke();
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

let shows = false,
  asked = 0,
  meetings: Meetings = { pairs: [], open: [] };
let chosen: { pair: number; region: number } | null = null; ///< the region that stands out; null: all alike
const drawn = new THREE.Group(),
  textures = KINDS.map(({ shape, colour }) => picture(shape, colour));
world.extra.parent!.add(drawn);
const list = h('div', { id: 'meetings', role: 'status' });

const regionsOf = (pair: Pair): number[] => [...new Set(pair.contacts.map((c) => c[1]))].sort((a, b) => a - b);
const deepest = (contacts: Contact[]): number => contacts.reduce((d, c) => Math.max(d, c[8]), 0);
const counts = (contacts: Contact[]): number[] => KINDS.map((_, kind) => contacts.filter((c) => c[0] === kind).length);

function clear(): void {
  for (const o of drawn.children as (THREE.Points | THREE.LineSegments)[]) {
    o.geometry.dispose();
    (o.material as THREE.Material).dispose();
  }
  drawn.clear();
}

/// Draws the contacts: a mark on a, and a line from there to b's point.
function draw(): void {
  clear();
  const isChosen = (pair: number, c: Contact) => !chosen || (chosen.pair === pair && chosen.region === c[1]);
  for (const bright of [false, true]) {
    const contacts = meetings.pairs.flatMap((pair, i) => pair.contacts.filter((c) => isChosen(i, c) === bright)),
      opacity = bright ? 1 : PALE;
    const add = (o: THREE.Object3D, order: number) => {
      o.raycast = () => {};
      o.renderOrder = order;
      drawn.add(o);
    };
    const geometry = (points: THREE.Vector3[]) => new THREE.BufferGeometry().setFromPoints(points);
    if (!contacts.length) continue;
    add(
      new THREE.LineSegments(
        geometry(contacts.flatMap((c) => [vector(c, 2), vector(c, 5)])),
        new THREE.LineBasicMaterial({ color: LINE, depthTest: false, transparent: true, opacity }),
      ),
      12,
    );
    KINDS.forEach((_, kind) => {
      const own = contacts.filter((c) => c[0] === kind);
      if (own.length)
        add(
          new THREE.Points(
            geometry(own.map((c) => vector(c, 2))),
            new THREE.PointsMaterial({
              map: textures[kind],
              size: kind === 0 ? 7 : 12,
              sizeAttenuation: false,
              depthTest: false,
              transparent: true,
              opacity,
            }),
          ),
          13 + kind,
        );
    });
  }
  world.redraw();
}

function write(): void {
  const sign = (kind: number) =>
      h('span', { style: `color: ${KINDS[kind].colour}`, 'aria-hidden': 'true' }, `${KINDS[kind].shape} `),
    name = (i: number) => state.facts[i]?.name ?? '';
  const row = (pair: number, region: number, contacts: Contact[]) => {
    const choose = (yes: boolean) => {
      chosen = yes ? { pair, region } : null;
      draw();
    };
    return h(
      'tr',
      {
        tabIndex: 0,
        onmouseenter: () => choose(true),
        onmouseleave: () => choose(false),
        onfocus: () => choose(true),
        onblur: () => choose(false),
      },
      h('th', { scope: 'row' }, region < 0 ? 'inside' : String(region + 1)),
      ...counts(contacts).map((n) => h('td', { class: 'number' }, String(n))),
      h('td', { class: 'number' }, (1000 * deepest(contacts)).toFixed(3)),
    );
  };
  const table = (pair: Pair, i: number) => {
    const regions = regionsOf(pair),
      real = regions.filter((r) => r >= 0).length;
    return h(
      'table',
      { class: 'answers' },
      h(
        'caption',
        {},
        `${name(pair.a)} and ${name(pair.b)}: ${real} region${real === 1 ? '' : 's'}, ${digits(1000 * deepest(pair.contacts))} mm deep`,
      ),
      h(
        'thead',
        {},
        h(
          'tr',
          {},
          h('th', { scope: 'col' }, 'Region'),
          ...KINDS.map(({ name }, kind) => h('th', { scope: 'col' }, sign(kind), name)),
          h('th', { scope: 'col' }, 'mm deep'),
        ),
      ),
      h(
        'tbody',
        {},
        ...regions.map((r) =>
          row(
            i,
            r,
            pair.contacts.filter((c) => c[1] === r),
          ),
        ),
      ),
    );
  };
  const { pairs, open } = meetings,
    left = open.length > 0 && h('p', { class: 'note' }, `Without a closed surface, so not in it: ${open.map(name).join(', ')}.`);
  fill(
    list,
    ...(shows
      ? [
          ...pairs.map(table),
          pairs.length === 0 && h('p', { class: 'note' }, 'No two objects touch. Move one into another.'),
          left,
          pairs.length > 0 &&
            h(
              'p',
              { class: 'note' },
              'A vertex in the other object, an edge across an edge, or two faces; lines lead to the point on the other surface. Point at a region to see it alone.',
            ),
        ]
      : []),
  );
}

async function refresh(): Promise<void> {
  const request = ++asked,
    looks = shows && state.mode === 'look';
  const found =
    looks && state.facts.length > 1
      ? await fetchJson<Meetings>('/api/contacts').catch((e) => {
          trouble(e);
          return null;
        })
      : null;
  if (request !== asked) return;
  meetings = found ?? { pairs: [], open: [] };
  chosen = null;
  draw();
  write();
}

let timer = 0;
on(['scene', 'mode'], () => {
  clearTimeout(timer);
  timer = window.setTimeout(() => void refresh(), 80);
});

export const meetingsCard = card(
  'Contacts between objects',
  check(
    'Show them',
    false,
    (yes) => {
      shows = yes;
      void refresh();
    },
    'show-meetings',
    'Of the whole surfaces: vertices, edges and faces',
  ),
  list,
);

/// For tests.
export const shownMeetings = () => ({ ...meetings, drawn: drawn.children.length });
