// The npm package in Chromium, and the page without a server: a static host, a worker, nothing else.
// usage: node static_test.mjs PAGE CHROMIUM FOLDER PACKAGE MODEL...     beside each model its .answers, as the native program prints
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { browser, drop, feel, folder, openPage, require, run, settled, sqmap as pageFolder, test, unfold, until } from './harness.mjs';

const [, , , , , packageFolder, ...models] = process.argv;
const here = path.dirname(fileURLToPath(import.meta.url));
const mounts = { '/some/where/': pageFolder, '/live/': pageFolder, '/npm/': packageFolder, '/models/': path.dirname(models[0]), '/programs/': path.join(here, '../anywhere') };
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.wasm': 'application/wasm' };

/// The picture that the documentation has instead of a live model, until it is clicked.
const live = execFileSync('/usr/bin/python3', ['-c', 'import docs_site; print(docs_site.live("models/hand.sqmap", ""))'], { cwd: path.join(here, '../../scripts'), encoding: 'utf8' });
const pages = { '/': '<!doctype html><title>blank</title>', '/guide.html': `<!doctype html><title>guide</title>${live.split('```')[1].replace('{raw} html', '')}` };

/// A host of files: no header that would share memory between threads.
const asked = [];
const host = http.createServer((request, reply) => {
  const where = decodeURIComponent(request.url.split('?')[0]), mount = Object.keys(mounts).find((m) => where.startsWith(m));
  asked.push(where);
  if (where in pages) { reply.setHeader('Content-Type', 'text/html').end(pages[where]); return; }
  const file = mount && path.join(mounts[mount], where.slice(mount.length) || 'index.html');
  if (!file || where.includes('..') || !fs.existsSync(file)) { reply.writeHead(404).end('none'); return; }
  reply.setHeader('Content-Type', TYPES[path.extname(file)] ?? 'application/octet-stream').end(fs.readFileSync(file));
});
await new Promise((resolve) => { host.listen(0, '127.0.0.1', resolve); });
const base = `http://127.0.0.1:${host.address().port}`, address = `${base}/some/where/`;
let page;

const torus = (around, along) => {
  const lines = [];
  for (let i = 0; i < around; ++i)
    for (let j = 0; j < along; ++j) {
      const a = (2 * Math.PI * i) / around, b = (2 * Math.PI * j) / along, r = 1 + 0.3 * Math.cos(b);
      lines.push(`v ${r * Math.cos(a)} ${r * Math.sin(a)} ${0.3 * Math.sin(b)}`);
    }
  const at = (i, j) => 1 + (i % around) * along + (j % along);
  for (let i = 0; i < around; ++i)
    for (let j = 0; j < along; ++j) lines.push(`f ${at(i, j)} ${at(i + 1, j)} ${at(i + 1, j + 1)}`, `f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i, j + 1)}`);
  return `${lines.join('\n')}\n`;
};
/// Shows one object alone, so that others do not hide it.
const frame = async (object) => { await page.evaluate((i) => window.sqmap.world.frame(i), object); await settled(page); };
const facts = () => page.evaluate(() => window.sqmap.facts());

for (const model of models)
  test(`the npm package answers in Chromium as native code does: ${path.basename(model)}`, async () => {
    const blank = await browser.newPage();
    await blank.goto(`${base}/`);
    const lines = await blank.evaluate(async (name) => {
      const [{ load }, { hashes }, file] = await Promise.all([import('/npm/index.js'), import('/programs/hashes.mjs'), fetch(`/models/${name}`)]);
      return hashes((await load()).open(await file.arrayBuffer()));
    }, path.basename(model));
    await blank.close();
    assert.deepEqual(lines, fs.readFileSync(model.replace(/\.sqmap$/, '.answers'), 'utf8').trim().split('\n').slice(-lines.length));
  });

test('the npm package refuses in Chromium with name, element and cure', async () => {
  const blank = await browser.newPage();
  await blank.goto(`${base}/`);
  const refusal = await blank.evaluate(async () => {
    const { load, SqmapError } = await import('/npm/index.js');
    try { (await load()).bake({ vertices: [[0, 0, 0]], triangles: [[0, 1, 9]] }); } catch (e) { return { ours: e instanceof SqmapError, ...e }; }
    return null;
  });
  await blank.close();
  assert.equal(refusal.name, 'E_INDEX');
  assert.match(refusal.element, /^triangles\[0\]$/);
  assert.ok(refusal.ours && refusal.cure);
});

test('it opens its model from a host of files, in any folder', async () => {
  const before = asked.length;
  page = await openPage(address, { viewport: { width: 1360, height: 800 } });
  await settled(page);
  assert.deepEqual((await facts()).map((f) => f.name), ['hand']);
  assert.equal(await page.textContent('#connection'), 'in this page');
  assert.ok(asked.slice(before).every((where) => where.startsWith('/some/where/')), `it asks for ${asked.slice(before)}`);
  assert.ok(!(await page.evaluate(() => window.crossOriginIsolated)));
  assert.ok(await page.isVisible('#invite'));
});

test('a touch gives the force of the spring, and the tool stays on the surface', async () => {
  await feel(page, 0, 0.3);
  await page.waitForTimeout(1200);
  const felt = await page.evaluate(() => { const f = window.sqmap.frame(); return { ...f, ticks: f.ticks.length, k: window.sqmap.status().settings.stiffness, limit: window.sqmap.status().limit }; });
  const force = Math.hypot(...felt.force), expected = Math.min(felt.k * felt.depth, felt.limit);
  assert.ok(Math.abs(force - expected) < 0.1 * expected, `${force} N of ${expected} N`);
  assert.ok(felt.ticks > 0 && felt.object === 0 && felt.part >= 0);
  assert.ok(await page.evaluate(() => window.sqmap.world.tool.springNow() > 0.0005));
  await until(page, () => window.sqmap.map.over().feet.length > 0);
  await page.screenshot({ path: path.join(folder, 'touch.png') });
  // Every millisecond is computed: the clock of the ticks goes on by one each.
  const steps = await page.evaluate(async () => {
    const seen = [];
    for (let i = 0; i < 20; ++i) { await new Promise((r) => { setTimeout(r, 20); }); const { ticks } = window.sqmap.frame(); for (let k = 1; 5 * k < ticks.length; ++k) seen.push(ticks[5 * k + 4] - ticks[5 * k - 1]); }
    return seen;
  });
  assert.ok(steps.length > 20 && steps.every((s) => Math.abs(s - 0.001) < 1e-5), `${steps.slice(0, 5)}`);
  await page.mouse.up();
});

test('STOP ends the force until Resume', async () => {
  await feel(page, 0, 0.2);
  await page.keyboard.press('Space');
  await page.waitForSelector('#resume');
  assert.ok(await page.evaluate(() => window.sqmap.status().stopped));
  await page.mouse.up();
  await page.click('#resume');
  await until(page, () => !window.sqmap.status().stopped);
});

test('what was recorded is computed again to the bit', async () => {
  await page.click('#record');
  await feel(page, 0, 0.2);
  await page.waitForTimeout(400);
  await page.mouse.up();
  await page.waitForTimeout(200);
  await page.click('#record');
  await page.click('#again');
  await until(page, () => /the same to the bit/.test(document.querySelector('#again-words').textContent));
});

test('saved as one file it has its program, its models and the recording inside, and is touched without any host', async () => {
  await page.evaluate(() => { document.querySelector('#export').open = true; });
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-page')]);
  const file = path.join(folder, 'whole.html');
  await download.saveAs(file);
  await page.evaluate(() => { document.querySelector('#export').open = false; });
  const before = asked.length, alone = await openPage(`file://${path.resolve(file)}`), from = page;
  try {
    assert.deepEqual(await alone.evaluate(() => window.sqmap.facts().map((f) => f.hash)), (await facts()).map((f) => f.hash));
    await until(alone, () => window.sqmap.recorder.count > 10);
    assert.ok(await alone.evaluate(() => { const { recorder, world } = window.sqmap; for (let t = 0; t <= recorder.seconds; t += 0.02) { recorder.seek(t); if (world.tool.arrowNow().length > 0.001) return true; } return false; }), 'what was felt is replayed');
    await alone.click('#to-now');
    page = alone;
    await frame(0);
    await feel(alone, 0, 0.2);
    await alone.mouse.up();
    await drop(alone, ['ring.obj', torus(24, 12)]);
    await until(alone, () => window.sqmap.facts().length === 2 && window.sqmap.facts()[1].name === 'ring');
    assert.equal(asked.length, before, 'no host was asked');
  } finally { page = from; await alone.close(); }
});

test('a dropped mesh is checked, baked and felt', async () => {
  await drop(page, ['ring.obj', torus(40, 20)]);
  await page.waitForSelector('#verdict.good');
  assert.match(await page.textContent('#verdict .word'), /Taken as it is/);
  await until(page, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());
  const ring = (await facts())[1];
  assert.ok(ring.name === 'ring' && ring.parts.every((p) => p.certified) && ring.triangles === 1600);
  await page.click('#close-verdict');
  await frame(1);
  await feel(page, 1, 0.2);
  await page.screenshot({ path: path.join(folder, 'dropped.png') });
  await page.mouse.up();
});

test('touch goes on while a mesh is baked, and a bake can be ended', async () => {
  await drop(page, ['large.obj', torus(200, 100)]);
  await until(page, () => !document.querySelector('#progress').hidden);
  await frame(1);
  await feel(page, 1, 0.2);
  const frames = await page.evaluate(() => window.sqmap.frames());
  await until(page, (n) => window.sqmap.frames() > n + 30, frames);
  assert.ok(await page.evaluate(() => !document.querySelector('#progress').hidden), 'it still bakes');
  await page.mouse.up();
  await page.click('#queue li:last-child button');
  await until(page, () => document.querySelector('#progress').hidden);
  await drop(page, ['small.obj', torus(24, 12)]);
  await until(page, () => window.sqmap.facts().length === 3);
  assert.deepEqual((await facts()).map((f) => f.name), ['hand', 'ring', 'small']);
  await page.evaluate(() => window.sqmap.link.say({ say: 'remove', object: 2 }));
  await until(page, () => window.sqmap.facts().length === 2);
  await page.click('#close-verdict');
});

test('files that are refused say why, where and what helps', async () => {
  const model = fs.readFileSync(path.join(pageFolder, 'models/hand.sqmap'));
  for (const [name, content, code, element, cure] of [
    ['wrong.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n', /Not taken \(E_/, /At .*(face|line)/, /What helps/],
    ['open.stl', 'nothing of the sort', /Not taken \(E_/, /At /, /What helps/],
    ['cut.sqmap', model.subarray(0, 5000).toString('latin1'), /Not taken \(E_FORMAT\)/, /At file/, /What helps/],
  ]) {
    await drop(page, [name, content]);
    await until(page, (n) => document.querySelector('#verdict h2')?.textContent === n && document.querySelector('#verdict.bad'), name);
    const said = await page.textContent('#verdict');
    for (const words of [code, element, cure]) assert.match(said, words, name);
  }
  await page.screenshot({ path: path.join(folder, 'refused.png') });
  await page.click('#close-verdict');
  assert.equal((await facts()).length, 2);
});

test('looking works as with a server: fields, maps, sections, slices, edits', async () => {
  await page.click('#tab-look');
  await page.selectOption('#colour', 'error');
  await page.waitForSelector('.legend .bar');
  await page.selectOption('#colour', 'parts');
  await frame(0);
  const parts = (await facts())[0].parts.length;
  await page.evaluate(() => window.sqmap.link.say({ say: 'split', object: 0, part: 0 }));
  await until(page, (n) => window.sqmap.facts()[0].parts.length > n, parts);
  await page.evaluate(() => window.sqmap.link.say({ say: 'undo', object: 0 }));
  await until(page, (n) => window.sqmap.facts()[0].parts.length === n, parts);
  await page.evaluate(() => { document.querySelector('#export').open = true; });
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-glb')]);
  const to = path.join(folder, 'hand.glb');
  await download.saveAs(to);
  const report = await require('gltf-validator').validateBytes(new Uint8Array(fs.readFileSync(to)));
  assert.equal(report.issues.numErrors, 0, JSON.stringify(report.issues.messages.slice(0, 3)));
  assert.equal(download.suggestedFilename(), 'hand.glb');
  await page.screenshot({ path: path.join(folder, 'look.png') });
});

test('what needs the program is not offered, and the page says so', async () => {
  assert.ok(await page.isHidden('#tab-dress'));
  await page.click('#tab-touch');
  await unfold(page);
  assert.match(await page.textContent('#device-facts'), /sqmap view/);
});

test('an address names the models; one that is missing is said', async () => {
  const other = await openPage(`${address}?model=models/dumbbell.sqmap&model=none.sqmap`, { viewport: { width: 720, height: 480 } });
  assert.deepEqual(await other.evaluate(() => window.sqmap.facts().map((f) => f.name)), ['dumbbell']);
  await until(other, () => /none\.sqmap: the host answers 404/.test(document.querySelector('#notice').textContent));
  await other.screenshot({ path: path.join(folder, 'small.png') });
  await other.close();
});

test('a page of the documentation loads its live model once it is clicked', async () => {
  const guide = await browser.newPage({ viewport: { width: 900, height: 640 } }), before = asked.length;
  await guide.goto(`${base}/guide.html`);
  await guide.waitForTimeout(300);
  assert.deepEqual(asked.slice(before).filter((where) => where.startsWith('/live/')), []);
  await guide.click('button');
  await guide.frameLocator('iframe').locator('body[data-ready]').waitFor({ timeout: 60000 });
  const inside = guide.frames().find((f) => f.url().includes('/live/'));
  assert.deepEqual(await inside.evaluate(() => window.sqmap.facts().map((f) => f.name)), ['hand']);
  await guide.waitForTimeout(1500);
  await guide.screenshot({ path: path.join(folder, 'guide.png') });
  await guide.close();
});

test('a game pad touches, presses, turns and stops', async () => {
  const pad = await openPage(address, { viewport: { width: 1100, height: 720 } });
  await settled(pad);
  await pad.evaluate(() => {
    const [x, y] = [0, 1].map(() => ({ pressed: false, value: 0 }));
    window.pad = { mapping: 'standard', axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ ...x, ...y })) };
    Object.defineProperty(navigator, 'getGamepads', { value: () => [window.pad] });
    window.dispatchEvent(new Event('gamepadconnected'));
  });
  const set = (button, value) => pad.evaluate(([b, v]) => { window.pad.buttons[b] = { pressed: v > 0, value: v }; }, [button, value]);
  const push = async (button) => { await set(button, 1); await pad.waitForTimeout(150); await set(button, 0); await pad.waitForTimeout(100); };
  const stick = (axis, value) => pad.evaluate(([a, v]) => { window.pad.axes[a] = v; }, [axis, value]);
  await push(0);
  await until(pad, () => window.sqmap.hand.holding && window.sqmap.frame()?.engaged && Math.hypot(...window.sqmap.frame().force) > 0.2);
  const before = await pad.evaluate(() => ({ press: window.sqmap.hand.press, tool: window.sqmap.frame().tool, eye: window.sqmap.world.pose() }));
  await set(7, 1);
  await until(pad, (p) => window.sqmap.hand.press > p + 0.001, before.press);
  await set(7, 0);
  await stick(0, 0.8);
  await until(pad, (t) => Math.hypot(...window.sqmap.frame().tool.map((x, k) => x - t[k])) > 0.004, before.tool);
  await stick(0, 0);
  await stick(2, 1);
  await until(pad, (e) => Math.hypot(...window.sqmap.world.pose().map((x, k) => x - e[k])) > 0.02, before.eye);
  await stick(2, 0);
  await push(1);
  await until(pad, () => window.sqmap.status().stopped && !window.sqmap.hand.holding);
  await pad.close();
});

test('a headset: the controller touches, a pinching hand takes over, the grip is STOP', async () => {
  const emulator = path.join(path.dirname(require.resolve('iwer')), '../build/iwer.min.js');
  const worn = await openPage(address, { viewport: { width: 1100, height: 720 } }, { from: { async newPage(options) {
    const made = await browser.newPage(options);
    await made.addInitScript({ path: emulator });
    await made.addInitScript(() => { window.device = new window.IWER.XRDevice(window.IWER.metaQuest3); window.device.installRuntime({ forceInstall: true }); });
    return made;
  } } });
  await worn.waitForSelector('#immersive:not([hidden])');
  await worn.click('#immersive');
  await until(worn, () => window.sqmap.immersive() === 'right');
  // Over the highest point, then into it: where the page puts the objects, 1.35 m above the floor and 0.5 m before the eyes.
  const move = (above) => worn.evaluate((h) => {
    const { world } = window.sqmap, middle = world.objects.box().getCenter(world.controls.target.clone());
    let top = null;
    world.objects.eachVertex(0, 1, (_, v) => { if (!top || v.y > top.y) top = v.clone(); });
    window.device.controllers.right.position.set(top.x - middle.x, top.y - middle.y + 1.35 + h, top.z - middle.z - 0.5);
    return top.toArray();
  }, above);
  const top = await move(0.05);
  await until(worn, (t) => { const f = window.sqmap.frame(); return f && Math.hypot(f.hand[0] - t[0], f.hand[1] - t[1] - 0.05, f.hand[2] - t[2]) < 0.002; }, top);
  await move(0.002);
  await until(worn, () => { const f = window.sqmap.frame(); return f.engaged && f.force[1] > 0.3 && f.contacts > 0; });
  await worn.screenshot({ path: path.join(folder, 'headset.png') });
  const value = (button, v) => worn.evaluate(([b, x]) => window.device.controllers.right.updateButtonValue(b, x), [button, v]);
  await value('squeeze', 1);
  await until(worn, () => window.sqmap.status().stopped && Math.hypot(...window.sqmap.frame().force) === 0);
  await value('squeeze', 0);
  await move(0.05);
  await value('trigger', 1);
  await until(worn, () => !window.sqmap.status().stopped);
  await value('trigger', 0);
  await worn.evaluate(() => { window.device.primaryInputMode = 'hand'; window.device.hands.left.updatePinchValue(1); });
  await until(worn, () => window.sqmap.immersive() === 'left');
  await worn.evaluate(() => window.device.activeSession.end());
  await until(worn, () => window.sqmap.immersive() === null);
  await settled(worn);
  await worn.close();
});

await run(() => page);
