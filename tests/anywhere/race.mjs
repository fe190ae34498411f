// The distances of the npm package beside those of three-mesh-bvh: the same triangles, the same points, in turns. Prints the best
// time a point of each, how many distances are the same to a float, and the largest difference.
// usage: node race.mjs PACKAGE MODEL     needs npm's packages in apps/viewer/web (./dev view installs them)
import {readFileSync} from "node:fs";
import {createRequire} from "node:module";
import {resolve} from "node:path";
import {pathToFileURL} from "node:url";
import {crc, pointsOf} from "./hashes.mjs";

const rounds = 5, count = 20000;

const [folder, file] = process.argv.slice(2);
const require = createRequire(new URL("../../apps/viewer/web/", import.meta.url));
const THREE = require("three"), {MeshBVH} = require("three-mesh-bvh");
const {load} = await import(pathToFileURL(resolve(folder, "index.js")));
const model = (await load()).open(readFileSync(file)), {vertices, triangles} = model.mesh;
const points = pointsOf(model).subarray(9, 9 + 3 * count);  // the first three are there to be refused

const geometry = new THREE.BufferGeometry();
geometry.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
const tree = new MeshBVH(geometry), at = new THREE.Vector3(), found = {};
function theirs() {
  const out = new Float64Array(count);
  for (let i = 0; i < count; ++i) {
    at.set(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    out[i] = tree.closestPointToPoint(at, found).distance;
  }
  return out;
}

const rivals = {
  "three-mesh-bvh, unsigned": theirs,
  "sqmap, unsigned, exact": () => model.closestPoints(points).distance,
  "sqmap, signed, exact in its band": () => model.distances(points, {band: 0}).distance,
  "sqmap, signed, exact everywhere": () => model.distances(points).distance,
};
const best = {}, answers = {};
for (let round = 0; round < rounds; ++round)
  for (const [name, run] of Object.entries(rivals)) {
    const begin = process.hrtime.bigint();
    answers[name] = run();
    best[name] = Math.min(best[name] ?? Infinity, Number(process.hrtime.bigint() - begin) / count);
  }

const facts = model.facts, truth = answers["three-mesh-bvh, unsigned"];
console.log(`${file}: ${facts.triangles} triangles, ${count} points, best of ${rounds} rounds`);
for (const name of Object.keys(rivals)) {
  const d = answers[name].map(Math.abs);
  const same = d.reduce((n, x, i) => n + (Math.fround(x) === Math.fround(truth[i])), 0);
  const far = name.includes("band") ? facts.band : Infinity;  // beyond it there is a bound
  const most = d.reduce((m, x, i) => (truth[i] <= far ? Math.max(m, Math.abs(x - truth[i])) : m), 0);
  console.log(`  ${name.padEnd(33)} ${best[name].toFixed(0).padStart(6)} ns a point  ${(best["three-mesh-bvh, unsigned"] / best[name]).toFixed(2).padStart(5)} times as fast  ` +
    `${((100 * same) / count).toFixed(2)} % the same float, at most ${((100 * most) / facts.rMax).toExponential(1)} % of R_max apart  ${crc(Float32Array.from(d))}`);
}
