// Processor time of a probe on a model at layer 3 through the npm package: as speed.c.
// usage: node speed.mjs PACKAGE MODEL PROBE_MODEL
import {readFileSync} from "node:fs";
import {resolve} from "node:path";
import {pathToFileURL} from "node:url";

const [folder, file, tool] = process.argv.slice(2);
const {load} = await import(pathToFileURL(resolve(folder, "index.js")));
const sqmap = await load();
const model = sqmap.open(readFileSync(file)), other = sqmap.open(readFileSync(tool));
const facts = model.facts, own = other.facts;
const vertices = other.mesh.vertices.map((x, i) => (x - own.centre[i % 3]) * facts.rMax / own.rMax + facts.centre[i % 3]);
const probe = sqmap.probe(vertices);
let best = Infinity, all = 0, found = 0;
for (let round = 0; round < 40; ++round) {
  const begin = process.cpuUsage();
  found = 0;
  for (let i = 0; i < 500; ++i)
    found += model.probe(probe, {capacity: 0, probePose: [1, 0, 0, facts.rMax * 0.03 * (i % 25), 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}).found;
  const taken = process.cpuUsage(begin).user;
  best = Math.min(best, taken);
  all += taken;
}
console.log(`${(best / 500).toFixed(2)} us a probe of ${own.vertices} points, mean ${(all / 40 / 500).toFixed(2)}, ${found} contacts`);
