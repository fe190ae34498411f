// Hashes of all that a model answers at 100,000 points, as answers.c prints them: in Node and in browsers.
const count = 100000;

/** In [0, 1): of the i-th number, by integers alone. */
function uniform(i) {
  let h = Math.imul(i, 0x9e3779b1);
  h = Math.imul(h ^ (h >>> 16), 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}

/** count points about a model: three of four near its surface. */
export function pointsOf(model) {
  const facts = model.facts, vertices = facts.hasExact ? model.mesh.vertices : undefined;
  const xyz = new Float64Array(3 * count);
  for (let i = 0; i < count; ++i)
    for (let k = 0; k < 3; ++k) {
      const u = 2 * uniform(3 * i + k) - 1;
      xyz[3 * i + k] = i % 4 === 0 || vertices === undefined ? facts.centre[k] + 1.25 * facts.radius * u
                                                             : vertices[3 * (i % facts.vertices) + k] + 0.03125 * facts.rMax * u;
    }
  xyz[5] = Infinity;
  xyz[7] = 1e30;
  return xyz;
}

const table = Uint32Array.from({length: 256}, (_, i) => {
  let c = i;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

export function crc(...arrays) {
  let c = 0xffffffff;
  for (const a of arrays) {
    const values = a instanceof Float64Array ? a.map((x) => (Number.isNaN(x) ? -1e308 : x)) : a;
    for (const byte of new Uint8Array(values.buffer)) c = table[(c ^ byte) & 255] ^ (c >>> 8);
  }
  return (~c >>> 0).toString(16).padStart(8, "0");
}

/** The lines of answers.c for a model of the npm package. */
export function hashes(model) {
  const points = pointsOf(model), lines = [];
  for (const [i, layer] of [1, 2, 3, "exact"].entries()) {
    const a = model.query(points, {layer});
    lines.push(`layer ${i + 1}    ${crc(a.contact, a.depth, a.normal, a.closest, a.part, a.certain, a.status)}  ${a.contacts} inside`);
  }
  for (const [band, name] of [[0, "baked"], [Infinity, "infinite"]]) {
    const d = model.distances(points, {band});
    lines.push(`distances  ${crc(d.distance, d.gradient, d.closest, d.part, d.known, d.status)}  band ${name}`);
  }
  if (model.facts.hasExact) {
    const c = model.closestPoints(points);
    lines.push(`closest    ${crc(c.closest, c.distance, c.triangle)}`);
  }
  return lines;
}
