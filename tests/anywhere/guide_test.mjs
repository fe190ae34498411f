// Runs the JavaScript of the guide, block after block, in one module: what a block prints is what the text behind it shows.
// usage: node guide_test.mjs PACKAGE GUIDE [--update]      --update writes what is printed into the guide
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join, resolve} from "node:path";

const [folder, path, update] = process.argv.slice(2);
let guide = readFileSync(path, "utf8");
const blocks = [...guide.matchAll(/^```js\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?/gms)];
assert.ok(blocks.length >= 4, `${blocks.length} blocks`);
const home = mkdtempSync(join(tmpdir(), "guide-")), end = "-- the next block --";
try {
  mkdirSync(join(home, "node_modules"));
  symlinkSync(resolve(folder), join(home, "node_modules", "sqmap"));
  writeFileSync(join(home, "guide.mjs"), blocks.map(([, code]) => `${code}console.log(${JSON.stringify(end)});\n`).join(""));
  const printed = execFileSync("node", ["guide.mjs"], {cwd: home, encoding: "utf8"}).split(`${end}\n`);
  blocks.forEach(([all, code, text], k) => {
    if (update === "--update") guide = guide.replace(all, () => `\`\`\`js\n${code}\`\`\`\n\n\`\`\`text\n${printed[k]}\`\`\`\n`);
    else assert.equal(printed[k], text ?? "", `block ${k + 1}`);
  });
} finally {
  rmSync(home, {recursive: true});
}
if (update === "--update") writeFileSync(path, guide);
console.log(`guide: ${blocks.length} blocks of JavaScript print what it shows`);
