// The example that lists the clashes of a building, on a building with five overlaps whose depths are known. It runs in a folder of
// its own, where npm installs both packages from the archives that it packs, as it would from its registry.
// usage: node building_test.mjs PACKAGE WEB_IFC EXAMPLE      folders of the npm packages sqmap and web-ifc
import assert from "node:assert/strict";
import {execFileSync, spawnSync} from "node:child_process";
import {copyFileSync, existsSync, mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join, resolve} from "node:path";
import {building, overlaps} from "./building.mjs";

const [sqmap, ifc, example] = process.argv.slice(2);
for (const [folder, cure] of [[sqmap, "./dev anywhere wasm"], [ifc, "npm install --prefix build/readers web-ifc@0.0.78"]])
  if (!existsSync(join(folder, "package.json"))) {
    console.log(`skipped: ${folder} is not here: ${cure}`);
    process.exit(0);
  }
const home = mkdtempSync(join(tmpdir(), "building-")), tolerance = 1e-6;  // m
const npm = (...words) => execFileSync("npm", [...words, "--silent", "--ignore-scripts"], {cwd: home, encoding: "utf8"});
try {
  const archives = [sqmap, ifc].map((folder) => `./${npm("pack", resolve(folder)).trim()}`);
  writeFileSync(join(home, "package.json"), "{}");
  npm("install", "--offline", "--no-audit", "--no-fund", ...archives);
  copyFileSync(example, join(home, "example.mjs"));
  writeFileSync(join(home, "building.ifc"), building());
  const printed = execFileSync("node", ["example.mjs", "building.ifc"], {cwd: home, encoding: "utf8"}), found = new Map();
  for (const [, a, b, millimetres, litres] of printed.matchAll(/^(.+) in (.+): ([\d.]+) mm deep, ([\d.]+) litres$/gm))
    found.set([a, b].sort().join(" and "), {depth: Number(millimetres) / 1000, litres: Number(litres)});
  for (const [a, b, depth, litres] of overlaps) {
    const clash = found.get([a, b].sort().join(" and "));
    assert.ok(clash, `${a} and ${b} are not listed:\n${printed}`);
    assert.ok(Math.abs(clash.depth - depth) <= tolerance, `${a} and ${b}: ${clash.depth} m, not ${depth}`);
    if (litres !== undefined) assert.ok(Math.abs(clash.litres - litres) <= 0.001, `${a} and ${b}: ${clash.litres} litres, not ${litres}`);
  }
  assert.equal(found.size, overlaps.length, printed);
  assert.match(printed, /^5 clashes of 14 elements$/m);
  const refused = (...words) => spawnSync("node", ["example.mjs", ...words], {cwd: home, encoding: "utf8"});
  for (const [words, said] of [[[], /^usage: /], [["building.ifc", "thick"], /^usage: /], [["no.ifc"], /no\.ifc/], [["example.mjs"], /example\.mjs/]]) {
    const {status, stderr, stdout} = refused(...words);
    const own = stdout.replace(/^\[WEB-IFC\].*\n/gm, "");
    assert.ok(status > 0 && said.test(stderr) && own === "" && stderr.split("\n").length === 2, `${words}: ${status}, ${stderr}${stdout}`);
  }
  console.log(`building: ${overlaps.length} clashes to ${tolerance} m`);
} finally {
  rmSync(home, {recursive: true});
}
