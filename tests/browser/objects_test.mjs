// The tree of objects, what is said of them, and an empty stage: hide, alone, move, turn, remove and take back.
// usage: node objects_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { drop, feel, folder, onSurface, openPage, run, settled, sqmap, start, test, until } from './harness.mjs';

const began = performance.now();
const { url } = await start();
const printed = performance.now() - began;
const wide = { viewport: { width: 1360, height: 800 } };
const page = await openPage(url, wide);
const facts = () => page.evaluate(() => window.sqmap.facts());
const there = () => page.evaluate(() => window.sqmap.world.objects.seenIn('both'));
const shot = (name) => page.screenshot({ path: path.join(folder, `${name}.png`) });
/// The button of an object in the tree.
const act = async (what, object) => page.click(`#${what}-${(await facts())[object].id}`);

test('the address is printed before anything is baked', async () => {
  assert.ok(printed < 1000, `${printed.toFixed(0)} ms`);
  assert.deepEqual((await facts()).map((f) => f.name), ['dumbbell', 'torus']);
  assert.match(await page.textContent('#purpose'), /Touch a 3D object and feel its force/);
  // Before anything is touched, the line of facts is about the object that is drawn large.
  const large = await page.evaluate(() => window.sqmap.facts()[window.sqmap.world.objects.focus].name);
  assert.ok((await page.textContent('#model-facts')).startsWith(`${large}: `));
  await shot('first');
});

test('press and depth are said in words and drawn, to 20 mm', async () => {
  assert.equal(await page.getAttribute('#s-press', 'max'), '20');
  await page.evaluate(() => { window.sqmap.hand.press = 0.006; window.sqmap.hand.deeper(0); });
  await settled(page);
  await feel(page, 0, 0.2);
  await until(page, () => /hand 6\.\d mm in, surface holds it [1-5]\.\d mm deep/.test(document.querySelector('#force').textContent));
  const { words, labels, frame } = await page.evaluate(() => { const f = window.sqmap.frame(); return { words: document.querySelector('#press-words').textContent, labels: [...document.querySelectorAll('.press-picture text')].map((t) => t.textContent), frame: { depth: f.depth, hand: f.hand, wanted: window.sqmap.hand.wanted.toArray(), normal: f.normal } }; });
  assert.match(words, /^The hand is 6\.\d mm in; the surface holds the tool [1-5]\.\d mm deep/);
  assert.ok(labels.some((t) => /^surface holds it: [\d.]+ mm$/.test(t)) && labels.some((t) => /^hand: 6\.\d mm$/.test(t)), labels.join('|'));
  // By the frame itself: the hand wants to be as far below the surface as it was told to press.
  const apart = frame.hand.reduce((s, x, k) => s + (x - frame.wanted[k]) * frame.normal[k], 0);
  assert.ok(Math.abs(frame.depth + apart - 0.006) < 0.0006, `${frame.depth} and ${apart}`);
  await shot('press');
  await page.mouse.up();
  assert.ok(await page.isHidden('#purpose'), 'a touch ends the first sentence');
});

test('a picked point has the coordinates of its file', async () => {
  await page.click('#tab-look');
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 0)));
  await until(page, () => /Point/.test(document.querySelector('#numbers').textContent));
  const said = /Point(-?[\d.]+), (-?[\d.]+), (-?[\d.]+) in the file/.exec(await page.textContent('#numbers')).slice(1).map(Number);
  // The file is what sqmap shapes writes: the nearest of its vertices lies a triangle away at most.
  const file = path.join(folder, 'dumbbell.obj');
  execFileSync(sqmap, ['shapes', 'dumbbell', '-o', file]);
  const vertices = fs.readFileSync(file, 'utf8').split('\n').filter((l) => l.startsWith('v ')).map((l) => l.split(' ').slice(1, 4).map(Number));
  const far = Math.min(...vertices.map((v) => Math.hypot(...v.map((x, k) => x - said[k])))), size = Math.max(...[0, 1, 2].map((k) => Math.max(...vertices.map((v) => v[k])) - Math.min(...vertices.map((v) => v[k]))));
  assert.ok(far < 0.05 * size, `${far} of ${size}`);
  const radius = Math.min(...vertices.map((v) => Math.hypot(...v))), own = Math.hypot(...said);
  assert.ok(own > 0.9 * radius, 'it lies on the surface, not in it');
});

test('a standard view frames what is selected', async () => {
  await act('object', 1);
  await page.click('#view-top');
  const off = await page.evaluate(() => { const s = window.sqmap, q = s.world.project(s.world.controls.target.clone().set(...s.facts()[1].position)); return Math.hypot(q.x, q.y); });
  assert.ok(off < 0.02, `${off}`);
});

test('hidden, an object is neither seen nor touched, and its mark is gone; alone hides the others', async () => {
  await act('object', 0);
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 0)));
  await until(page, () => document.querySelector('#pick-tag:not([hidden])'));
  await act('hide', 0);
  await until(page, () => window.sqmap.facts()[0].hidden);
  await until(page, () => window.sqmap.world.objects.seenIn('both').join() === '1');
  assert.ok(await page.isHidden('#pick-tag'), 'the mark goes with its object');
  await settled(page);
  await shot('hidden');
  // The program does not touch it, either: the tool goes through where it is.
  await page.click('#tab-touch');
  await page.evaluate(() => { const s = window.sqmap, f = s.facts()[0], t = s.world.controls.target.clone().set(...f.position); s.hand.moveTo(t.clone().add({ x: 0, y: 2 * f.half[1], z: 0 })); });
  await until(page, () => window.sqmap.status().touching);
  await page.evaluate(() => { const s = window.sqmap, f = s.facts()[0]; s.hand.moveTo(s.world.controls.target.clone().set(...f.position)); });
  await page.waitForTimeout(1000);
  const felt = await page.evaluate(() => window.sqmap.frame());
  assert.equal(felt.contacts, 0);
  await page.evaluate(() => window.sqmap.hand.letGo());
  await act('hide', 0);
  await until(page, () => !window.sqmap.facts()[0].hidden);
  await act('alone', 1);
  await until(page, () => window.sqmap.facts()[0].hidden && !window.sqmap.facts()[1].hidden);
  await act('alone', 1);
  await until(page, () => window.sqmap.facts().every((f) => !f.hidden));
  assert.deepEqual(await there(), [0, 1]);
});

test('the line of facts names what is touched, then what is selected, and nothing that is hidden', async () => {
  const names = (name) => until(page, (n) => document.querySelector('#model-facts').textContent.startsWith(`${n}: `), name);
  await page.click('#tab-touch');
  await page.evaluate(() => window.sqmap.world.frame());
  await settled(page);
  await feel(page, 1, 0.2);
  await page.mouse.up();
  await until(page, () => window.sqmap.frame().contacts === 0);
  await names('torus');
  await act('object', 0);
  await names('dumbbell');
  await act('hide', 0);
  await names('torus');
  await act('hide', 0);
  await until(page, () => !window.sqmap.facts()[0].hidden);
  await page.click('#tab-look');
  await act('alone', 1);
  await names('torus');
  await act('alone', 1);
  await until(page, () => window.sqmap.facts().every((f) => !f.hidden));
  await page.click('#tab-touch');
  await page.evaluate(() => window.sqmap.world.frame());
  await settled(page);
  await feel(page, 1, 0.2);
  await page.mouse.up();
  await act('remove', 0);
  await until(page, () => window.sqmap.facts().length === 1);
  await names('torus');
  await page.click('#take-back');
  await until(page, () => window.sqmap.facts().length === 2);
  await names('torus');
});

test('numbers move an object, with its mark and its surface; its axis turns it', async () => {
  await page.click('#tab-look');
  await act('object', 1);
  await page.click('#view-front');
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 1)));
  await until(page, () => document.querySelector('#pick-tag:not([hidden])'));
  await act('move', 1);
  await page.waitForSelector('#move-x');
  const before = (await facts())[1], mark = await page.evaluate(() => window.sqmap.world.tool.marked().toArray());
  const to = Math.round(1000 * before.position[0]) + 60;
  await page.fill('#move-x', String(to));
  await page.press('#move-x', 'Enter');
  await until(page, (x) => Math.abs(window.sqmap.facts()[1].position[0] - x / 1000) < 1e-6, to);
  const by = to / 1000 - before.position[0], after = (await facts())[1];
  assert.equal(after.revision, before.revision, 'what was computed of it stays');
  const moved = await page.evaluate(() => window.sqmap.world.tool.marked().toArray());
  assert.ok(Math.abs(moved[0] - mark[0] - by) < 1e-6 && Math.abs(moved[1] - mark[1]) < 2e-6, `the mark moves along: ${mark} to ${moved}`);
  // The drawn surface stands where the program touches it.
  const box = await page.evaluate(() => { const p = window.sqmap.world.objects.surfaceOf(1).geometry.attributes.position.array; let low = 9, high = -9; for (let i = 0; i < p.length; i += 3) { low = Math.min(low, p[i]); high = Math.max(high, p[i]); } return [low, high]; });
  assert.ok(Math.abs((box[0] + box[1]) / 2 - after.position[0]) < 1e-4, box.join());
  await settled(page);
  await shot('move');
  // A drag of a handle does the same.
  const handle = await page.evaluate(() => { const s = window.sqmap, f = s.facts()[1], b = document.querySelector('#stage').getBoundingClientRect(), p = s.world.controls.target.clone().set(...f.position), d = s.world.camera.position.distanceTo(p); const q = s.world.pixel(p.setX(p.x + 0.035 * d)); return [b.left + q.x, b.top + q.y]; });
  await page.mouse.move(...handle);
  await page.mouse.down();
  await page.mouse.move(handle[0] + 40, handle[1], { steps: 6 });
  await page.mouse.up();
  await until(page, (x) => window.sqmap.facts()[1].position[0] > x + 0.005, after.position[0]);
  const half = after.half;
  await page.selectOption('#up-axis', 'x');
  await until(page, () => window.sqmap.facts()[1].up === 'x' && window.sqmap.world.objects.ready());
  const turned = (await facts())[1];
  assert.ok(Math.abs(turned.half[1] - half[0]) < 1e-6, 'its width is its height now');
  assert.ok(Math.abs(turned.position[1] - turned.half[1] - (after.position[1] - half[1])) < 1e-6, 'it stands on the same ground');
  await page.click('#tab-touch');
  await page.evaluate(() => window.sqmap.world.frame(1));
  await settled(page);
  await feel(page, 1, 0.1);
  await page.mouse.up();
  await page.click('#tab-look');
  await page.selectOption('#up-axis', 'y');
  await until(page, () => window.sqmap.facts()[1].up === 'y');
  await act('move', 1);
});

test('a name is changed, a removed object comes back at its place, without a question', async () => {
  await act('object', 0);
  await page.fill('#object-name', 'weight');
  await page.press('#object-name', 'Enter');
  await until(page, () => window.sqmap.facts()[0].name === 'weight');
  const id = (await facts())[0].id;
  await act('remove', 0);
  await until(page, () => window.sqmap.facts().length === 1);
  assert.match(await page.textContent('#notice'), /weight is removed.*Undo/);
  await page.click('#take-back');
  await until(page, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());
  assert.deepEqual((await facts()).map((f) => [f.id === id, f.name]), [[true, 'weight'], [false, 'torus']]);
});

test('an empty stage says what to do, and undo fills it again', async () => {
  await page.click('#remove-all');
  await until(page, () => window.sqmap.facts().length === 0);
  assert.match(await page.textContent('#empty'), /Drop a mesh .*DAE.* here/);
  await shot('empty');
  for (const n of [1, 2]) {
    await page.click('#restore');
    await until(page, (count) => window.sqmap.facts().length === count, n);
  }
  assert.ok(await page.isHidden('#empty'));
});

test('parts of one colour do not touch each other', async () => {
  // Rings of parts, a wheel whose hub touches all others, and a chain of pairs: more than there are hues.
  const least = await page.evaluate(() => {
    const { distinctColours } = window.sqmap, n = 24, ring = Array.from({ length: n }, (_, i) => [(i + 1) % n, (i + n - 1) % n]);
    const wheel = [Array.from({ length: n - 1 }, (_, i) => i + 1), ...Array.from({ length: n - 1 }, (_, i) => [0, 1 + ((i + 1) % (n - 1)), 1 + ((i + n - 2) % (n - 1))])];
    const all = Array.from({ length: 16 }, (_, i) => Array.from({ length: 16 }, (_, k) => k).filter((k) => k !== i));
    return [ring, wheel, all].map((g) => { const c = distinctColours(g); return Math.min(...g.flatMap((beside, i) => beside.map((k) => Math.hypot(...c[i].map((x, d) => x - c[k][d]))))); });
  });
  assert.ok(least[0] > 0.25 && least[1] > 0.2 && least[2] > 0.05, least.join(' '));
});

test('a DAE file opens, as it does from the command line', async () => {
  if (spawnSync('assimp', ['version']).status !== 0) { console.log('skipped: assimp is not there (Debian: assimp-utils)'); return; }
  const obj = path.join(folder, 'box.obj'), dae = path.join(folder, 'box.dae');
  execFileSync(sqmap, ['shapes', 'rounded_box', '-o', obj]);
  execFileSync('assimp', ['export', obj, dae]);
  await drop(page, ['box.dae', fs.readFileSync(dae, 'utf8')]);
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.objects.ready());
  assert.equal((await facts())[2].name, 'box');
  assert.match(await page.getAttribute('#file', 'accept'), /\.dae/);
});

test('the other kind of maps comes into sight beside its object, though the eye was near a point', async () => {
  await page.click('#tab-look');
  await page.selectOption('#colour', 'error');
  await page.waitForSelector('#worst:not([hidden])');
  await page.click('#worst');
  await page.selectOption('#beside', 'twin');
  const loaded = () => { const { objects } = window.sqmap.world, pair = objects.pair(); return pair !== null && window.sqmap.world.halved && objects.ready() && !!objects.meshOf(pair[1]); };
  await until(page, loaded);
  await settled(page);
  const off = await page.evaluate(() => {
    const { world } = window.sqmap, box = world.objects.box(world.objects.pair()[0]), q = world.project(box.getCenter(world.controls.target.clone()));
    return { middle: Math.hypot(q.x, q.y), edges: [box.min, box.max].map((p) => world.project(p.clone())).map((p) => Math.max(Math.abs(p.x), Math.abs(p.y))) };
  });
  assert.ok(off.middle < 0.2 && off.edges.every((e) => e < 1.2 && e > 0.05), JSON.stringify(off));
  await page.screenshot({ path: path.join(folder, 'both-maps.png') });
  await page.selectOption('#beside', 'none');
  await page.selectOption('#colour', 'parts');
});

for (const [name, options] of [['dark', { ...wide, colorScheme: 'dark' }], ['narrow', { viewport: { width: 390, height: 844 } }]])
  test(`pictures: ${name}`, async () => {
    const other = await openPage(url, options);
    await settled(other);
    await other.screenshot({ path: path.join(folder, `first-${name}.png`) });
    await other.click('#tab-look');
    if (await other.isVisible('#sheet')) await other.click('#sheet');
    await other.click(`#move-${(await facts())[1].id}`);
    await other.waitForSelector('#move-x');
    await other.click(`#parts-${(await facts())[0].id}`);
    await other.waitForTimeout(400);
    await other.screenshot({ path: path.join(folder, `tree-${name}.png`) });
    await other.close();
  });

await run(() => page);
