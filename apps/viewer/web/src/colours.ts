// Colours of parts and fields; light enough for dark lines, dark enough for white ones.

const HUES = [
  0x4e79a7, 0xf28e2b, 0x59a14f, 0xe15759, 0x76b7b2, 0xb07aa1, 0xedc948, 0x9c755f, 0xff9da7, 0x8fc7ea, 0xa8a83c, 0xc9b2e0,
];

export type Rgb = [number, number, number];

const channels = (hex: number): Rgb => [(hex >> 16) / 255, ((hex >> 8) & 255) / 255, (hex & 255) / 255];
export const css = (c: Rgb): string => `rgb(${c.map((x) => Math.round(255 * x)).join(' ')})`;

export function partColour(part: number): Rgb {
  const base = channels(HUES[part % HUES.length]);
  const round = Math.floor(part / HUES.length) % 3;
  return round === 0 ? base : (base.map((x) => (round === 1 ? 0.5 * x + 0.5 : 0.55 * x)) as Rgb);
}

/// Colours of parts such that neighbours differ most: each takes the hue farthest from those that its neighbours have.
export function distinctColours(neighbours: number[][]): Rgb[] {
  const lab = (c: Rgb): Rgb => {
    const y = 0.3 * c[0] + 0.59 * c[1] + 0.11 * c[2];
    return [1.2 * y, 0.7 * (c[0] - y), 0.7 * (c[2] - y)];
  };
  const far = (a: Rgb, b: Rgb) => Math.hypot(...lab(a).map((x, k) => x - lab(b)[k]));
  const out: Rgb[] = [];
  neighbours.forEach((beside, part) => {
    const taken = beside.filter((n) => n < part).map((n) => out[n]);
    // Among the hues that are far enough from every neighbour's the next in turn keeps the colours varied.
    const least = (k: number) => Math.min(9, ...taken.map((c) => far(c, partColour(k))));
    const order = HUES.map((_, k) => (part + k) % HUES.length),
      more = Array.from({ length: 2 * HUES.length }, (_, k) => HUES.length + k); // lighter and darker ones, where all hues are taken
    const best = order.find((k) => least(k) > 0.25) ?? [...order, ...more].reduce((a, b) => (least(b) > least(a) ? b : a));
    out.push(partColour(best));
  });
  return out;
}

function ramp(stops: number[], t: number): Rgb {
  const x = Math.min(Math.max(t, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(x), stops.length - 2);
  const a = channels(stops[i]),
    b = channels(stops[i + 1]);
  return a.map((v, k) => v + (x - i) * (b[k] - v)) as Rgb;
}

/// Cream over orange to dark red: a surface without error stays plain.
const errorColour = (t: number): Rgb => ramp([0xf3ead7, 0xf6c27a, 0xe9722f, 0xb01f24, 0x5e0a1e], t);
/// Viridis.
export const sequentialColour = (t: number): Rgb => ramp([0x440154, 0x3b528b, 0x21918c, 0x5ec962, 0xfde725], t);
/// Black to white, in steps that look even.
export const greyColour = (t: number): Rgb => ramp([0x000000, 0xffffff], t);
export const divergingColour = (t: number): Rgb => ramp([0x2166ac, 0x92c5de, 0xf7f7f7, 0xf4a582, 0xb2182b], (t + 1) / 2);
export const MISS = -1; // the error of a triangle that a layer misses
const MISSED: Rgb = [0.14, 0.34, 0.84];
const UNKNOWN: Rgb = [0.54, 0.56, 0.6];

export interface Scale {
  title: string;
  ticks: [number, string][];
  colour: (t: number) => Rgb;
  of: (value: number) => Rgb;
  known: (value: number) => boolean; ///< false: the value says why there is none
  range: [number, number]; ///< the values at which the colours end
  isOfKinds?: boolean; ///< values are kinds, and none lies between two of them
  key: string; ///< equal keys give equal colours of equal values
}
/// The values at which a field's colours end, if the user has chosen them.
export type Range = [number, number] | null;

const shown = (x: number): string =>
  x !== 0 && (Math.abs(x) >= 1000 || Math.abs(x) < 0.01) ? x.toExponential(1) : Number(x.toPrecision(2)).toString();

const MADE_UP: Rgb = [0.9, 0.42, 0.05],
  OF_THE_FILE: Rgb = [0.84, 0.86, 0.84];
const REGIONS = [channels(0xe8e4dc), channels(0x2a9d8f), channels(0xd4145a)]; // convex, Q1, Q2, as sqmap render --what regions has them
const NO_STRENGTH = -20; // the Boundary Strength of a triangle without a locale
const ERRORS: [number, number] = [0.01, 1]; // percent of R_max
const TITLES: Record<string, string> = {
  error: 'Depth error of layer 3, % of its size',
  'error-2': 'Depth error of layer 2, % of its size',
  difference: 'Depths of the two projections differ by, % of its size',
  protrusion: 'Protrusion, over its mean',
  curvature: 'Gaussian curvature × size², hyperbolic blue',
  strength: 'Boundary Strength of locales: 1 on a plane',
};

/// The scale of a field with these values, which the legend shows.
export function colourField(kind: string, values: Float32Array, chosen: Range): Scale {
  const all = () => true;
  if (kind === 'made-up') {
    const colour = (t: number) => (t > 0.5 ? MADE_UP : OF_THE_FILE);
    return {
      title: 'Surface that a cure made up',
      colour,
      of: colour,
      known: all,
      ticks: [
        [0, 'of the file'],
        [1, 'made up'],
      ],
      range: [0, 1],
      key: '',
    };
  }
  if (kind === 'regions') {
    const of = (v: number) => REGIONS[v] ?? UNKNOWN;
    return {
      title: 'Surface that a paper model’s maps see',
      colour: (t) => of(Math.min(2, Math.floor(3 * t))),
      of,
      known: (v) => v >= 0,
      ticks: [
        [0, 'convex'],
        [0.5, 'concave'],
        [1, 'hidden'],
      ],
      range: [0, 2],
      key: '',
      isOfKinds: true,
    };
  }
  if (kind === 'locales') {
    const features = Math.floor(values.reduce((most, v) => Math.max(most, v), -1) / 2) + 1;
    const of = (v: number): Rgb =>
      v < 0 ? UNKNOWN : (partColour(Math.floor(v / 2)).map((x) => (v % 2 ? 0.55 * x + 0.45 : x)) as Rgb);
    return {
      title: `Locales about ${features} salient feature${features === 1 ? '' : 's'}`,
      colour: (t) => of(2 * Math.min(features - 1, Math.floor(features * t))),
      of,
      known: (v) => v >= 0,
      ticks: [],
      range: [0, 1],
      key: '',
      isOfKinds: true,
    };
  }
  const title = TITLES[kind];
  if (kind === 'strength') {
    const end = chosen ? chosen[1] : 2;
    return {
      title,
      colour: (t) => divergingColour(2 * t - 1),
      ticks: [
        [0, `< −${shown(end)}`],
        [0.5, '0: cylinder'],
        [1, `> ${shown(end)}`],
      ],
      range: [-end, end],
      key: `${end}`,
      of: (v) => (v < NO_STRENGTH / 2 ? UNKNOWN : divergingColour(Math.max(-1, Math.min(1, v / end)))),
      known: (v) => v > NO_STRENGTH / 2,
    };
  }
  if (isError(kind)) {
    const [low, high] = chosen ?? ERRORS,
      least = Math.max(low, 1e-6),
      at = (v: number) => Math.log(Math.max(v, least) / least) / Math.log(Math.max(high / least, 1.0001));
    return {
      title,
      colour: errorColour,
      ticks: [
        [0, `< ${shown(least)}`],
        [0.5, shown(Math.sqrt(least * high))],
        [1, `> ${shown(high)}`],
      ],
      range: [least, high],
      key: `${low} ${high}`,
      of: (v) => (v === MISS ? MISSED : v < 0 ? UNKNOWN : errorColour(at(v))),
      known: (v) => v >= 0,
    };
  }
  if (kind === 'protrusion') {
    let low = Infinity,
      high = -Infinity;
    for (const v of values) {
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
    [low, high] = chosen ?? [low, high];
    return {
      title,
      colour: sequentialColour,
      ticks: [
        [0, shown(low)],
        [1, shown(high)],
      ],
      range: [low, high],
      key: `${low} ${high}`,
      of: (v) => sequentialColour((v - low) / Math.max(high - low, 1e-9)),
      known: all,
    };
  }
  const sizes = Float32Array.from(values, Math.abs).sort();
  const end = Math.max(chosen ? chosen[1] : sizes[Math.floor(0.95 * (sizes.length - 1))], 1e-9);
  return {
    title,
    colour: (t) => divergingColour(2 * t - 1),
    ticks: [
      [0, `< −${shown(end)}`],
      [0.5, '0'],
      [1, `> ${shown(end)}`],
    ],
    range: [-end, end],
    key: `${end}`,
    of: (v) => divergingColour(Math.sign(v) * Math.sqrt(Math.min(Math.abs(v) / end, 1))),
    known: all,
  };
}
/// Tells whether a field has logarithmic colours; a value below 0 of such a field says why there is none.
const isError = (kind: string): boolean => kind.startsWith('error') || kind === 'difference';
