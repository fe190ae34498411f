// sqmap's npm package beside @mujoco/mujoco 3 on the same meshes: errors of signed distances and of contacts of a small ball,
// bytes, and processor time of the build. The truth is every triangle and the solid angle, computed here.
// usage: node mujoco3.mjs PACKAGE MUJOCO MESH.obj...      PACKAGE: build/anywhere/npm; MUJOCO: node_modules/@mujoco/mujoco
import {readFileSync} from "node:fs";
import {basename, resolve} from "node:path";
import {pathToFileURL} from "node:url";

const [ours, theirs, ...meshes] = process.argv.slice(2);
const {load} = await import(pathToFileURL(resolve(ours, "index.js")));
const {default: loadMujoco} = await import(pathToFileURL(resolve(theirs, "mujoco.js")));
const sqmap = await load(), mujoco = await loadMujoco();
const POINTS = 1000, BALLS = 100, BAND = 0.05, BALL = 0.01;  // shares of R_max

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = v => Math.sqrt(dot(v, v));

function random(seed) {
  return () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}

function readObj(file) {
  const vertices = [], triangles = [];
  for (const line of readFileSync(file, "utf8").split("\n")) {
    const words = line.trim().split(/\s+/);
    if (words[0] === "v") vertices.push(words.slice(1, 4).map(Number));
    if (words[0] === "f") triangles.push(words.slice(1, 4).map(w => parseInt(w) - 1));
  }
  return {vertices, triangles};
}

/** Distance to a segment from a. */
function toSegment(p, a, b) {
  const along = sub(b, a), t = Math.max(0, Math.min(1, dot(sub(p, a), along) / dot(along, along)));
  return norm(sub(p, [a[0] + t * along[0], a[1] + t * along[1], a[2] + t * along[2]]));
}

function toTriangle(p, a, b, c) {
  const n = cross(sub(b, a), sub(c, a)), over = [[a, b], [b, c], [c, a]].every(([u, v]) => dot(cross(n, sub(v, u)), sub(p, u)) >= 0);
  if (over && norm(n) > 0) return Math.abs(dot(sub(p, a), n)) / norm(n);
  return Math.min(toSegment(p, a, b), toSegment(p, b, c), toSegment(p, c, a));
}

/** Signed distance by all triangles; inside where their solid angles add up (van Oosterom and Strackee 1983). */
function truth(mesh, p) {
  let nearest = Infinity, angle = 0;
  for (const t of mesh.triangles) {
    const [a, b, c] = t.map(i => mesh.vertices[i]);
    nearest = Math.min(nearest, toTriangle(p, a, b, c));
    const [u, v, w] = [sub(a, p), sub(b, p), sub(c, p)], [x, y, z] = [norm(u), norm(v), norm(w)];
    angle += 2 * Math.atan2(dot(u, cross(v, w)), x * y * z + dot(u, v) * z + dot(u, w) * y + dot(v, w) * x);
  }
  return Math.abs(angle) > 2 * Math.PI ? -nearest : nearest;
}

function measured(make) {
  const begin = process.cpuUsage();
  const made = make();
  const spent = process.cpuUsage(begin);
  return [made, (spent.user + spent.system) / 1e6];
}

/** MuJoCo's own field: values at the corners of an octree's leaves, interpolated, in the frame to which it moves the mesh. */
function mujocoDistance(model, p) {
  const rotation = model.mesh_quat, d = sub(p, model.mesh_pos), q = rotation.slice(1).map(x => -x), w = rotation[0];
  const t = cross(q, d).map(x => 2 * x), turned = cross(q, t).map((x, k) => d[k] + w * t[k] + x);
  const box = model.oct_aabb, corner = k => box[k] - box[3 + k];
  const clamped = turned.map((x, k) => Math.min(Math.max(x, corner(k)), box[k] + box[3 + k]));
  let node = 0;
  for (;;) {
    const at = clamped.map((x, k) => (x - box[6 * node + k]) / box[6 * node + 3 + k] / 2 + 0.5);
    if (model.oct_child[8 * node] < 0) {
      let sum = norm(sub(turned, clamped));
      for (let j = 0; j < 8; ++j)
        sum += at.reduce((product, x, k) => product * (j >> k & 1 ? x : 1 - x), 1) * model.oct_coeff[8 * node + j];
      return sum;
    }
    node = model.oct_child[8 * node + at.reduce((child, x, k) => child + (x < 0.5 ? 0 : 1 << k), 0)];
  }
}

function mujocoModel(mesh, kind, radius) {
  return mujoco.MjModel.from_xml_string(`<mujoco><option sdf_initpoints="40" sdf_iterations="10"/><asset><mesh name="m"
    vertex="${mesh.vertices.flat().join(" ")}" face="${mesh.triangles.flat().join(" ")}" inertia="exact"/></asset><worldbody>
    <geom type="${kind}" mesh="m" pos="0 0 0"/><body><freejoint/><geom type="sphere" size="${radius}"/></body></worldbody></mujoco>`);
}

/** How deep a ball is, as MuJoCo says: of its deepest contact; 0 of none. Of two fields that is at best half the overlap. */
function mujocoDepth(model, data, p) {
  // The geom stands where its mesh was moved to: a point of the mesh is a point of the world.
  data.qpos.set([...p, 1, 0, 0, 0]);
  mujoco.mj_fwdPosition(model, data);
  const list = data.contact;
  let depth = 0;
  for (let i = 0; i < list.size(); ++i) depth = Math.max(depth, -list.get(i).dist);
  list.delete();
  return depth;
}

function line(name, found, expected, rMax) {
  const off = expected.map((x, i) => 100 * Math.abs(found[i] - x) / rMax).sort((a, b) => a - b);
  const wrong = expected.filter((x, i) => x < 0 !== found[i] < 0).length;
  return `${name}: p95 ${off[Math.floor(0.95 * off.length)].toFixed(4)} %, max ${off.at(-1).toFixed(4)} %, wrong sides ${wrong}`;
}

for (const file of meshes) {
  const mesh = readObj(file);
  const [model, bakeTime] = measured(() => sqmap.bake({vertices: mesh.vertices, triangles: mesh.triangles}));
  const {rMax} = model.facts, radius = BALL * rMax;
  const [sdf, sdfTime] = measured(() => mujocoModel(mesh, "sdf", radius));
  const hull = mujocoModel(mesh, "mesh", radius);
  const next = random(1), points = [], distances = [];
  while (points.length < POINTS) {
    const [a, b, c] = mesh.triangles[Math.floor(next() * mesh.triangles.length)].map(i => mesh.vertices[i]);
    const u = Math.sqrt(next()), v = next(), n = cross(sub(b, a), sub(c, a)), off = (2 * next() - 1) * BAND * rMax / (norm(n) || 1);
    points.push([0, 1, 2].map(k => (1 - u) * a[k] + u * (1 - v) * b[k] + u * v * c[k] + off * n[k]));
    distances.push(truth(mesh, points.at(-1)));
  }
  console.log(`${basename(file)}: ${mesh.triangles.length} triangles`);
  console.log(`  built in   sqmap ${bakeTime.toFixed(1)} s, MuJoCo ${sdfTime.toFixed(1)} s`);
  const bytes = sdf.oct_aabb.byteLength + sdf.oct_child.byteLength + sdf.oct_coeff.byteLength + sdf.oct_depth.byteLength;
  console.log(`  memory     sqmap ${(model.facts.bytes / 1e6).toFixed(2)} MB, MuJoCo's field ${(bytes / 1e6).toFixed(2)} MB`);
  console.log(line("  distance   sqmap ", model.distances(points.flat(), {band: 0}).distance, distances, rMax));
  console.log(line("  distance   MuJoCo", points.map(p => mujocoDistance(sdf, p)), distances, rMax));
  const touching = points.map((p, i) => i).filter(i => Math.abs(distances[i]) < radius).slice(0, BALLS);
  const centres = touching.map(i => points[i]), depths = touching.map(i => radius - distances[i]);
  console.log(line("  ball depth sqmap ", [...model.distances(centres.flat(), {band: 0}).distance].map(d => Math.max(0, radius - d)), depths, rMax));
  for (const [name, other] of [["MuJoCo's field", sdf], ["MuJoCo's hull", hull]]) {
    const data = new mujoco.MjData(other), [found, spent] = measured(() => centres.map(p => mujocoDepth(other, data, p)));
    if (other === sdf) console.log(line("  ball depth MuJoCo's field, doubled", found.map(x => 2 * x), depths, rMax));
    console.log(`${line(`  ball depth ${name}`, found, depths, rMax)}, missed ${found.filter(x => x === 0).length} of ${found.length}, ` +
      `${(1e6 * spent / found.length).toFixed(0)} us`);
    data.delete();
  }
  for (const m of [sdf, hull]) m.delete();
  model.close();
}
