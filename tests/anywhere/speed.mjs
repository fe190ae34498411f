// Time of a probe on a model at layer 3 through the npm package, as speed.c, and of a bake: in Node processor time, in Chromium, where
// it is named, the clock's.
// usage: node speed.mjs PACKAGE MODEL PROBE_MODEL [MESH [CHROMIUM]]     Chromium needs npm's packages (./dev view installs them)
import {existsSync, readFileSync} from "node:fs";
import {createServer} from "node:http";
import {createRequire} from "node:module";
import {basename, resolve} from "node:path";
import {fileURLToPath, pathToFileURL} from "node:url";
import {bake, probes} from "./speed_loops.mjs";

const [folder, model, tool, mesh, chromium] = process.argv.slice(2);

async function inNode() {
  const sqmap = await (await import(pathToFileURL(resolve(folder, "index.js")))).load(), now = () => process.cpuUsage().user;
  console.log(`Node: ${probes(sqmap, readFileSync(model), readFileSync(tool), now)}`);
  if (mesh) console.log(`Node: ${bake(sqmap, basename(mesh), readFileSync(mesh), now)}`);
}

async function inChromium() {
  const files = {"/speed_loops.mjs": fileURLToPath(new URL("speed_loops.mjs", import.meta.url)), "/model": model, "/tool": tool, "/mesh": mesh};
  const types = {mjs: "text/javascript", js: "text/javascript", wasm: "application/wasm"};
  const host = createServer((request, reply) => {
    if (request.url === "/") { reply.setHeader("Content-Type", "text/html").end("<!doctype html><title>speed</title>"); return; }
    const file = files[request.url] ?? resolve(folder, basename(request.url));
    if (!existsSync(file)) { reply.writeHead(404).end(); return; }
    reply.setHeader("Content-Type", types[file.split(".").pop()] ?? "application/octet-stream").end(readFileSync(file));
  });
  await new Promise((done) => { host.listen(0, "127.0.0.1", done); });
  const {chromium: type} = createRequire(new URL("../../apps/viewer/web/", import.meta.url))("playwright-core");
  const browser = await type.launch({executablePath: chromium, args: ["--no-sandbox"]}), page = await browser.newPage();
  page.setDefaultTimeout(0);
  await page.goto(`http://127.0.0.1:${host.address().port}/`);
  const lines = await page.evaluate(async (name) => {
    const [{load}, {bake, probes}] = await Promise.all([import("/npm/index.js"), import("/speed_loops.mjs")]);
    const bytes = async (what) => new Uint8Array(await (await fetch(what)).arrayBuffer());
    const sqmap = await load(), now = () => 1000 * performance.now();
    return [probes(sqmap, await bytes("/model"), await bytes("/tool"), now), bake(sqmap, name, await bytes("/mesh"), now)];
  }, basename(mesh));
  for (const line of lines) console.log(`Chromium ${browser.version()}: ${line}`);
  await browser.close();
  host.close();
}

await inNode();
if (chromium) await inChromium();
