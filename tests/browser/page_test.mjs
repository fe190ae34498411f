// The page of `sqmap view` in Chromium: what a person would do, and what the program says beside it.
// usage: node page_test.mjs SQMAP CHROMIUM FOLDER     screenshots go to FOLDER; exit 0 where every claim holds
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { dressed, drop as dropped, feel as felt, folder, onSurface, openPage, require, run, settled, sqmap, start, test, unfold, until } from './harness.mjs';

const gltf = require('gltf-validator');
const { program, url } = await start();
/// Looks first, as most of these tests do.
const open = (options = {}) => openPage(url, options, { mode: 'look' });

let page;
const feel = (object, least) => felt(page, object, least);
const drop = (name, text) => dropped(page, [name, text]);
/// The entries of the menu of exports.
const inMenu = async (p, selector) => { await p.evaluate(() => { document.querySelector('#export').open = true; }); await p.click(selector); };

test('an address without its token is refused', async () => {
  const base = url.split('?')[0];
  assert.equal((await fetch(base)).status, 403);
  assert.equal((await fetch(`${base}?token=${'0'.repeat(32)}`)).status, 403);
  assert.equal((await fetch(`${base}api/object/0/mesh`)).status, 403);
  assert.equal((await fetch(`${base}api/upload?${url.split('?')[1]}`, { method: 'POST', body: 'x' })).status, 403);
  assert.equal((await fetch(`${base}api/upload?${url.split('?')[1]}`, { method: 'POST', body: 'x', headers: { Origin: 'http://evil.example' } })).status, 403);
});

test('the page loads and shows what the program says of its models', async () => {
  page = await open();
  const facts = await page.evaluate(() => window.sqmap.facts());
  assert.deepEqual(facts.map((f) => f.name), ['dumbbell', 'torus']);
  const text = await page.textContent('#facts');
  for (const f of facts) assert.ok(text.includes(`${f.parts.length} parts`) && text.includes('all certified'), text);
  assert.ok(await page.evaluate(() => window.sqmap.world.objects.ready()));
});

test('a click tells the numbers of the place and the part, and its map marks the place', async () => {
  // Twice: the numbers and the map take room from the stage, and what is under the pointer then may be another part.
  let x, y;
  for (let round = 0; round < 2; ++round) {
    await settled(page);
    [x, y] = await onSurface(page, 0);
    await page.mouse.click(x, y);
    await until(page, () => document.querySelector('#numbers').textContent.includes('Triangle'));
    await page.waitForSelector('.map-canvas:not([hidden])');
  }
  // A pointer that rests while the map is fetched tells nothing: it is moved until it does.
  for (let tries = 0; !/mm below the superquadric$/.test(await page.textContent('.map-words')); ++tries) {
    assert.ok(tries < 200, await page.textContent('.map-words'));
    await page.mouse.move(x + (tries % 2), y);
    await page.waitForTimeout(100);
  }
  // The other way: a click on the map picks a place of the same part.
  const before = await page.textContent('#numbers'), box = await (await page.$('.map-canvas')).boundingBox();
  for (const share of [0.4, 0.6, 0.2, 0.85]) {
    await page.click('.map-canvas', { position: { x: share * box.width, y: 0.5 * box.height } });
    if ((await page.textContent('#numbers')) !== before) break;
  }
  const after = await page.textContent('#numbers');
  assert.notEqual(after, before);
  assert.match(after, /Point.*Triangle\d+/);
});

test('a fold is darker, and shade costs no frame', async () => {
  await until(page, () => window.sqmap.world.objects.shaded());
  const open = await page.evaluate(() => window.sqmap.world.objects.surfaces().map((m) => { const l = m.geometry.attributes.look.array; let least = 255, most = 0; for (let i = 1; i < l.length; i += 2) { least = Math.min(least, l[i]); most = Math.max(most, l[i]); } return [least, most]; }));
  // Both have a hollow: the dumbbell's neck, the torus' hole.
  assert.ok(open[0][0] < 235 && open[1][0] < 252 && open.every(([, most]) => most > 250), open.join(' '));
});

test('spheres, samples, offset and hidden surface are drawn and taken away', async () => {
  for (const id of ['spheres', 'samples', 'offset', 'hidden']) await page.check(`#${id}`);
  await until(page, () => { const o = window.sqmap.world.objects.overlay(1); return o.spheres && o.offset && o.samples > 100; });
  await page.waitForSelector('#q2');
  assert.match(await page.textContent('#q2'), /torus \d+\.\d %/);
  await page.screenshot({ path: path.join(folder, 'overlays.png') });
  for (const id of ['spheres', 'samples', 'offset', 'hidden']) await page.uncheck(`#${id}`);
  await until(page, () => document.querySelector('.legend').hidden);
  const off = await page.evaluate(() => window.sqmap.world.objects.overlay(1));
  assert.ok(!off.spheres && off.samples === 0 && !off.offset && off.hidden === 0);
});

test('fields are coloured with a legend', async () => {
  await page.selectOption('#colour', 'error');
  await page.waitForSelector('.legend .bar');
  assert.match(await page.textContent('.legend'), /Depth error/);
  await page.screenshot({ path: path.join(folder, 'error.png') });
  // Smooth: within a triangle the colour runs from corner to corner, and neighbours of one part share their vertices.
  const field = await page.evaluate(() => {
    const { index, attributes: { color, position } } = window.sqmap.world.objects.surfaces()[1].geometry, c = color.array;
    let runs = 0;
    for (let t = 0; t < index.count; t += 3) { const [i, j] = [index.array[t], index.array[t + 1]]; if (Math.hypot(c[3 * i] - c[3 * j], c[3 * i + 1] - c[3 * j + 1], c[3 * i + 2] - c[3 * j + 2]) > 1e-3) ++runs; }
    return { runs: (3 * runs) / index.count, vertices: position.count, corners: index.count };
  });
  assert.ok(field.runs > 0.1 && 3 * field.vertices < field.corners, JSON.stringify(field));
  // The colours end where the user says, and the legend says so.
  const colours = () => page.evaluate(() => window.sqmap.world.objects.surfaces()[1].geometry.attributes.color.array.reduce((a, x) => a + x, 0));
  const automatic = await colours();
  assert.deepEqual(await page.evaluate(() => [Number(document.querySelector('#range-low').value), Number(document.querySelector('#range-high').value)]), [0.01, 1]);
  await page.fill('#range-high', '0.1');
  await page.press('#range-high', 'Enter');
  await until(page, () => document.querySelector('.legend').textContent.includes('> 0.1'));
  assert.ok((await colours()) < automatic, 'what is wrong is darker');
  await page.click('#range-auto');
  await until(page, () => document.querySelector('.legend').textContent.includes('> 1'));
  assert.equal(await colours(), automatic);
  await page.selectOption('#colour', 'parts');
  assert.ok(await page.isHidden('#range'));
});

test('by keys alone the scene is turned, asked, and its map read', async () => {
  await page.focus('#stage');
  const before = await page.evaluate(() => window.sqmap.world.pose());
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('+');
  const after = await page.evaluate(() => window.sqmap.world.pose());
  const distance = (p) => Math.hypot(p[0] - p[3], p[1] - p[4], p[2] - p[5]);
  assert.ok(Math.hypot(...[0, 1, 2].map((i) => after[i] - before[i])) > 0.01 && distance(after) < 0.95 * distance(before));
  // One object fills the middle of the view.
  await page.evaluate(() => window.sqmap.world.frame(1));
  let hit = null;
  for (let i = 0; i < 24 && !hit; ++i) {
    hit = await page.evaluate(() => window.sqmap.world.cast(0, 0));
    if (!hit) await page.keyboard.press(i % 2 ? 'ArrowUp' : 'ArrowLeft');
  }
  assert.ok(hit, 'turned, it comes to the middle');
  await page.keyboard.press('Enter');
  await until(page, (t) => document.querySelector('#numbers').textContent.includes(`Triangle${t}`), hit.triangle);
  await page.waitForSelector('.map-canvas:not([hidden])');
  await page.focus('.map-canvas');
  await until(page, () => { document.querySelector('.map-canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true })); return /mm below the superquadric$/.test(document.querySelector('.map-words').textContent); });
  const numbers = await page.textContent('#numbers');
  for (let i = 0; i < 6; ++i) await page.keyboard.press('Shift+ArrowDown');
  await page.keyboard.press('Enter');
  await until(page, (n) => document.querySelector('#numbers').textContent !== n, numbers);
  await page.focus('#stage');
  await page.keyboard.press('Home');
});

test('one mesh baked both ways stands side by side: answers, foot searches, level sets, differences', async () => {
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 0)));
  await page.waitForSelector('#inspect:not([hidden]) #rebake');
  assert.equal((await page.$$('#answers tbody tr')).length, 4);
  assert.ok(await page.isHidden('#projector'), 'a central map needs no search');
  await until(page, () => window.sqmap.world.traces.count().section > 1);
  assert.ok((await page.evaluate(() => { const c = document.querySelector('.section-canvas'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) if (d[i] > 0) ++n; return c.width === c.height && n; })) > 500, 'the section is drawn, and square');
  assert.equal(await page.evaluate(() => document.querySelector('#colour option[value=difference]').disabled), true);
  await page.click('#rebake');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.objects.ready());
  const facts = await page.evaluate(() => window.sqmap.facts());
  assert.deepEqual([facts[0].twin, facts[1].twin, facts[2].twin], [2, null, 0]);
  assert.ok(facts[0].central && !facts[2].central && facts[2].parts.length === facts[0].parts.length);
  // Both of each layer, and the triangles of both once; the point is as deep as it was set.
  await until(page, () => document.querySelectorAll('#answers tbody tr').length === 7);
  const rows = await page.$$eval('#answers tbody tr', (r) => r.map((tr) => Array.from(tr.children, (c) => c.textContent)));
  for (const row of rows) assert.match(row.at(-3), /inside/, row.join());
  for (const row of rows.slice(4)) assert.ok(Math.abs(Number(row.at(-2)) - 2) < 0.3, row.join());
  await page.screenshot({ path: path.join(folder, 'both.png') });
  // The server refuses what no page says: half a point, words, another axis, a part that is not there, a search on a central map.
  const [base, token] = url.split('?');
  for (const address of ['0/at/answers?at=1_2', '0/at/answers?at=a_b_c', '0/section/0/3?at=0_0_0', '0/section/99/0?at=0_0_0', '0/search/0?at=0_0_0', '2/search/99?at=0_0_0'])
    assert.equal((await fetch(`${base}api/object/${address}&${token}`)).status, 404, address);
  await page.selectOption('#colour', 'difference');
  await until(page, () => /differ by/.test(document.querySelector('.legend').textContent));
  const [differences, none] = await page.evaluate(() => [0, 1].map((o) => Array.from({ length: 50 }, (_, t) => window.sqmap.world.objects.fieldAt(o, 'difference', t))));
  assert.ok(differences.every((d) => d !== undefined && d < 5) && none.every((d) => d === undefined));
  await page.screenshot({ path: path.join(folder, 'difference.png') });
  await page.selectOption('#colour', 'parts');
  // Two views with one eye: the projections, then two layers; a click on either is one on the object.
  await page.evaluate(() => { window.sqmap.world.frame(0); });
  await page.selectOption('#beside', 'twin');
  await page.waitForSelector('#sides:not([hidden])');
  assert.deepEqual(await page.$$eval('#sides span', (all) => all.map((e) => e.textContent)), ['Central maps', 'The paper\u2019s maps']);
  const whole = await page.evaluate(() => window.sqmap.world.camera.aspect);
  await settled(page);
  const stage = await (await page.$('#stage')).boundingBox();
  assert.ok(Math.abs(whole - stage.width / stage.height / 2) < 0.02, 'each has half the stage');
  await page.mouse.move(stage.x + 1, stage.y + 1);
  await settled(page);
  // Both halves show the same shape: where the left one is not background the right one is not, either.
  await page.evaluate(() => window.sqmap.world.tool.mark(null));
  const alike = await page.evaluate(async () => {
    const blob = await window.sqmap.world.picture(), image = await createImageBitmap(blob), c = new OffscreenCanvas(image.width, image.height).getContext('2d');
    c.drawImage(image, 0, 0);
    const half = image.width >> 1, d = c.getImageData(0, 0, image.width, image.height).data, vivid = (x, y) => { const i = 4 * (y * image.width + x); return Math.max(d[i], d[i + 1], d[i + 2]) - Math.min(d[i], d[i + 1], d[i + 2]) > 60; };
    let both = 0, one = 0;
    for (let y = 2; y < image.height; y += 4) for (let x = 2; x < half; x += 4) { const a = vivid(x, y), b = vivid(x + half, y); if (a && b) ++both; else if (a || b) ++one; }
    return [both, one];
  });
  assert.ok(alike[0] > 500 && alike[1] < 0.1 * alike[0], alike.join(' '));
  await page.screenshot({ path: path.join(folder, 'beside.png') });
  const [lx, ly] = await page.evaluate(() => { const s = window.sqmap.world, b = document.querySelector('#stage').getBoundingClientRect(); for (let x = 0; x < 0.6; x += 0.02) if (s.cast(x, 0)?.object === 0) { const p = s.pixel(s.cast(x, 0).point); return [b.left + p.x, b.top + p.y]; } return null; });
  await page.mouse.click(lx + 0.5 * stage.width, ly);
  await until(page, () => /^Object.*Triangle/.test(document.querySelector('#numbers').textContent));
  await page.selectOption('#beside', 'layer-2');
  await until(page, () => document.querySelector('#sides').textContent === 'Layer 3Layer 2' && document.querySelector('#colour').value === 'error');
  await until(page, () => [0, 1, 2].every((o) => window.sqmap.world.objects.fieldAt(o, 'error-2', 0) !== undefined));
  const mean = (kind) => page.evaluate((k) => { const o = window.sqmap.world.objects; let sum = 0, n = 0; for (let t = 0; o.fieldAt(2, k, t) !== undefined; ++t) if (o.fieldAt(2, k, t) >= 0) { sum += o.fieldAt(2, k, t); ++n; } return sum / n; }, kind);
  assert.ok((await mean('error-2')) > 1.2 * (await mean('error')), 'the base map of the paper is coarser than the refined one');
  await settled(page);
  await page.screenshot({ path: path.join(folder, 'layers.png') });
  await page.selectOption('#beside', 'none');
  await page.selectOption('#colour', 'parts');
  assert.ok(await page.isHidden('#sides'));
  // The paper's maps: the three searches end at one foot, drawn over the map.
  await page.evaluate(() => window.sqmap.world.frame(2));
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 2)));
  await page.waitForSelector('#projector:not([hidden])');
  for (const [projector, words] of [['newton', /steps of Newton|samples looked at/], ['printed', /samples looked at/], ['pyramid', /samples looked at/]]) {
    await page.selectOption('#projector', projector);
    await until(page, () => /mm deep/.test(document.querySelector('#search-words').textContent));
    assert.match(await page.textContent('#search-words'), words);
    await until(page, () => window.sqmap.map.over().steps.length > 1);
  }
  const over = await page.evaluate(() => [window.sqmap.map.over().steps, window.sqmap.inspected().searches.searches.map((s) => s.footDistance)]);
  assert.ok(over[0].filter((s) => s.best).length > 1 && over[0].length > 25, 'a window of samples and what is below');
  assert.ok(Math.abs(over[1][0] - over[1][1]) < 5e-4, `Newton and the pyramid: ${over[1]}`);
  await page.check('#map-grey');
  await page.screenshot({ path: path.join(folder, 'search.png') });
  await page.uncheck('#map-grey');
});

test('feet of the contacts move on the map of the touched part, in both projections', async () => {
  for (const object of [0, 2]) {
    await page.click('#tab-touch');
    await page.evaluate((i) => window.sqmap.world.frame(i), object);
    await settled(page);
    const [x, y] = await feel(object, 0.1);
    await until(page, () => window.sqmap.map.over().feet.length > 3);
    const centre = () => page.evaluate(() => { const f = window.sqmap.map.over().feet; return [f.length, f.reduce((a, b) => a + b.x, 0) / f.length, f.reduce((a, b) => a + b.y, 0) / f.length, window.sqmap.map.over().part]; });
    const before = await centre();
    await page.screenshot({ path: path.join(folder, `feet-${object}.png`) });
    await page.mouse.move(x + 14, y + 10, { steps: 8 });
    await until(page, ([, fx, fy, part]) => { const o = window.sqmap.map.over(), f = o.feet, n = f.length; return n > 0 && (o.part !== part || Math.hypot(f.reduce((a, b) => a + b.x, 0) / n - fx, f.reduce((a, b) => a + b.y, 0) / n - fy) > 0.003); }, before);
    await page.mouse.up();
    await until(page, () => window.sqmap.map.over().feet.length === 0);
  }
  // The paper's force is that of its own maps: objects with central ones do not have it.
  assert.equal(await page.evaluate(() => document.querySelector('#force-law option[value=paper]').disabled), true);
  await page.click('#tab-look');
  await (await page.$$('#facts .object'))[2].click();
  await page.click('#remove');
  await until(page, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());
  assert.equal(await page.evaluate(() => window.sqmap.facts()[0].twin), null);
});

test('parts are drawn together, and nothing is drawn or coloured for nothing', async () => {
  // Counts of work, not of time: they are the same on every machine.
  const meter = () => page.evaluate(() => window.sqmap.meter.cost());
  const parts = await page.evaluate(() => window.sqmap.facts().reduce((n, f) => n + f.parts.length, 0));
  await page.evaluate(() => { window.sqmap.world.objects.select(-1, -1); window.sqmap.world.frame(); window.sqmap.world.tool.mark(null); });
  /// Once nothing has been drawn for a while: a still page has no frames.
  const still = async () => { for (let i = 0, last = -1; i < 100; ++i) { const m = await meter(); if (m.draws === last) return m; last = m.draws; await page.waitForTimeout(1000); } assert.fail('it draws on and on'); };
  const plain = await still();
  await page.check('#superquadrics');
  await page.check('#spheres');
  const all = await still();
  assert.ok(all.calls > plain.calls && all.calls <= plain.calls + 4 && parts > 4, `${all.calls} draw calls after ${plain.calls}, ${parts} parts`);
  assert.ok(all.triangles > plain.triangles);
  assert.equal(all.coloured, plain.coloured, 'what is drawn beside the surface leaves its colours');
  await page.uncheck('#superquadrics');
  await page.uncheck('#spheres');
  const last = await still();
  assert.equal(last.calls, plain.calls);
  assert.ok(last.draws <= last.frames);
  await until(page, () => /^Page: \d+ frames\/s, its scripts .* draw calls/.test(document.querySelector('#page-cost').textContent));
});

test('while it turns slowly it is drawn coarsely, and in full once it is still', async () => {
  const sides = () => page.evaluate(() => { const c = document.querySelector('#stage'); return c.width / c.parentElement.getBoundingClientRect().width / window.sqmap.world.finest(); });
  // A machine that takes 40 ms a frame as long as it draws all pixels; then one whose pace does not come from them.
  const paces = await page.evaluate(() => {
    const Pace = window.sqmap.world.pace.constructor, run = (ms, n) => { const p = new Pace(), shares = []; for (let i = 0, now = 1000; i < n; ++i) { const share = p.next(now); shares.push(share); now += ms(share); } return [p, shares]; };
    const [slow, coarse] = run((share) => 5 + 35 * share * share, 300), [, held] = run(() => 33.3, 300), [, fast] = run(() => 16.7, 300);
    const over = slow.still(1e6);
    slow.rested();
    return { coarse: coarse.at(-1), least: Math.min(...coarse), held: held.at(-1), heldLeast: Math.min(...held), fast: Math.min(...fast), over, again: slow.next(2e6) };
  });
  assert.ok(paces.coarse < 0.66 && paces.least >= 0.5, JSON.stringify(paces));
  assert.ok(paces.held === 1 && paces.heldLeast >= 0.75 && paces.fast === 1, 'pixels are not taken where that does not help');
  assert.ok(paces.over && paces.again > paces.coarse);
  await page.evaluate(async () => { for (let i = 0; i < 90; ++i) { window.sqmap.world.turn(0.005, 0); await new Promise(requestAnimationFrame); } });
  await until(page, () => { const c = document.querySelector('#stage'); return Math.abs(c.width / window.sqmap.world.finest() - c.parentElement.getBoundingClientRect().width) < 2; });
  assert.ok(Math.abs((await sides()) - 1) < 0.01);
});

test('a drag is felt: force, arrow and trace agree', async () => {
  await page.click('#tab-touch');
  await unfold(page);
  await settled(page);
  let felt = null;
  for (let tries = 0; !felt && tries < 8; ++tries) {
    const [x, y] = await feel(0, 0.2);
    await page.mouse.move(x + 3, y + 2, { steps: 3 });
    await page.waitForTimeout(700);
    felt = await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => {
      const s = window.sqmap, f = s.frame();
      resolve(f.faults || Math.hypot(...f.force) < 0.1 ? null : { force: f.force, normal: f.normal, depth: f.depth, object: f.object, arrow: s.world.tool.arrowNow(), chart: [s.charts.latest(0), s.charts.latest(1)], words: document.querySelector('#force').textContent });
    })));
    if (!felt) await page.mouse.up();
  }
  assert.ok(felt, 'a held touch keeps its force');
  const size = Math.hypot(...felt.force), unit = felt.force.map((c) => c / size);
  assert.equal(felt.object, 0);
  assert.ok(felt.arrow.visible && Math.abs(felt.arrow.length - 0.03 * size) < 1e-6);
  felt.arrow.direction.forEach((c, i) => assert.ok(Math.abs(c - unit[i]) < 1e-3));
  assert.ok(Math.abs(felt.chart[0] - size) < 1e-3, `${felt.chart[0]} against ${size}`);
  assert.ok(Math.abs(felt.chart[1] - 1000 * felt.depth) < 1e-3);
  // The push is outwards: within the friction cone about the normal.
  assert.ok(unit.reduce((sum, c, i) => sum + c * felt.normal[i], 0) > Math.cos(Math.atan(0.4) + 0.1));
  await until(page, () => [0, 1, 2].every((i) => window.sqmap.charts.top(i) > window.sqmap.charts.latest(i)), undefined);
  await page.evaluate(() => { window.sqmap.hand.press = 0.009; window.sqmap.hand.deeper(0); });
  await until(page, () => window.sqmap.charts.latest(1) > 2.4 && window.sqmap.charts.top(1) > window.sqmap.charts.latest(1));  // beyond where the axis begins
  await page.evaluate(() => { window.sqmap.hand.press = 0.004; window.sqmap.hand.deeper(0); });
  assert.match(felt.words, /N · .* mm deep/);
  await page.evaluate(() => { window.sqmap.world.pace.on = false; });
  await page.screenshot({ path: path.join(folder, 'touch.png') });
  await page.evaluate(() => { window.sqmap.world.pace.on = true; });
  // However many messages come, the page draws once a frame, and a message is as long as its ticks need.
  const cost = await page.evaluate(() => { const s = window.sqmap; return { ...s.meter.cost(), ticks: s.frame().ticks.length / 5 }; });
  assert.equal(cost.lastBytes, 4 * (43 + 5 * cost.ticks));
  assert.ok(cost.messages > 10 && cost.draws <= cost.frames && cost.chartDraws <= cost.frames);
  assert.match(await page.textContent('#counters'), /^Servo: [\d,]+ ticks; \d+ late/);
});

test('the space bar stops, and only Resume goes on', async () => {
  await page.keyboard.press('Space');
  await until(page, () => { const f = window.sqmap.frame(); return (f.faults & 16) !== 0 && Math.hypot(...f.force) === 0; });
  await page.mouse.up();
  await page.waitForSelector('#resume');
  assert.equal(await page.evaluate(() => window.sqmap.status().stopped), true);
  await page.click('#resume');
  await until(page, () => !window.sqmap.status().stopped);
  await page.waitForSelector('#resume', { state: 'detached' });
  await page.click('#stop');
  await page.waitForSelector('#resume');
  await page.keyboard.press('Enter');
  await until(page, () => !window.sqmap.status().stopped);
  assert.equal(await page.evaluate(() => document.activeElement.id), 'stage', 'another Enter does not stop again');
});

test('sliders reach the program', async () => {
  await page.locator('#s-stiffness').fill('800');
  await until(page, () => window.sqmap.status().settings.stiffness === 800);
  await page.selectOption('#layer', 'exact');
  await until(page, () => window.sqmap.status().settings.layer === 'exact');
  assert.ok(!/proven stable/.test(await page.textContent('#device-facts')), 'a device without hardware bears every stiffness');
});

test('eq. 33 and Auto have their sliders', async () => {
  await page.selectOption('#law', 'paper');
  await until(page, () => window.sqmap.status().settings.law === 'paper');
  assert.ok((await page.isHidden('#s-friction')) && (await page.isVisible('#s-f-c')));
  await page.locator('#s-f-c').fill('0.3');
  await page.locator('#s-k-f').fill('200');
  await until(page, () => { const s = window.sqmap.status().settings; return s.fC === 0.3 && s.kF === 200; });
  await page.selectOption('#layer', 'auto');
  await page.locator('#s-tolerance').fill('0.5');
  await until(page, () => { const s = window.sqmap.status().settings; return s.layer === 'auto' && Math.abs(s.tolerance - 0.0005) < 1e-9; });
  await page.screenshot({ path: path.join(folder, 'eq33.png') });
  await page.selectOption('#law', 'coulomb');
  await page.selectOption('#layer', 'exact');
  await until(page, () => { const s = window.sqmap.status().settings; return s.law === 'coulomb' && s.layer === 'exact'; });
});

test('what is felt is recorded, replayed as it was, saved and read back', async () => {
  await page.click('#record');
  await feel(0, 0.2);
  await page.waitForTimeout(400);
  const felt = await page.evaluate(() => Math.hypot(...window.sqmap.frame().force));
  await page.mouse.up();
  await page.click('#record');
  assert.ok((await page.evaluate(() => window.sqmap.recorder.count)) > 10);
  const saved = async (button, name) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)]);
    await download.saveAs(path.join(folder, name));
    return path.join(folder, name);
  };
  const to = await saved('#save-table', 'table.csv'), whole = await saved('#save-recording', 'touch.csv');
  // The longest arrow that a replay draws.
  const replayed = async () => {
    const done = page.evaluate(() => new Promise((resolve) => {
      let most = 0, again = 0;
      const r = window.sqmap.recorder, shown = r.onFrame;
      r.onFrame = (f, at, of) => { shown(f, at, of); const a = window.sqmap.world.tool.arrowNow(); if (window.sqmap.charts.latestAgain(0) > 0) ++again; if (a.visible) most = Math.max(most, a.length / 0.03); };
      document.querySelector('#replay').click();
      const wait = setInterval(() => { if (!r.replaying) { clearInterval(wait); r.onFrame = shown; resolve({ most, again, count: r.count }); } }, 30);
    }));
    return done;
  };
  const own = await replayed();
  assert.ok(own.most >= felt - 1e-6, `${own.most} against ${felt}`);
  // Computed again, as it was: the same bits. A machine that was too busy to hear of every tick says so.
  const again = async (wanted) => {
    await page.click('#again');
    await until(page, (w) => new RegExp(w).test(document.querySelector('#again-words').textContent) && !document.querySelector('#again').disabled, wanted);
    return page.textContent('#again-words');
  };
  const proof = await again('Replay draws it');
  assert.ok(/the same to the bit\..* of now: the same/.test(proof) || /ticks were lost/.test(proof), proof);
  // On another surface: without an object less, with another stiffness more or less.
  const stiffness = await page.inputValue('#s-stiffness');
  await page.locator('#s-stiffness').fill('300');
  await until(page, () => window.sqmap.status().settings.stiffness === 300);
  assert.match(await again('differs by at most'), /of now the force differs by at most [\d.]+ N/);
  assert.ok((await replayed()).again > 0, 'it is drawn beside');
  await page.locator('#s-stiffness').fill(stiffness);
  await until(page, (k) => window.sqmap.status().settings.stiffness === k, Number(stiffness));
  await page.setInputFiles('#recording-file', whole);
  await until(page, () => document.querySelector('#notice').textContent.includes('touch.csv: '));
  assert.match(await again('Replay draws it'), /the same to the bit|ticks were lost/, 'with its poses it is computed again');
  await page.setInputFiles('#recording-file', to);
  await until(page, () => document.querySelector('#notice').textContent.includes('table.csv: '));
  assert.ok(await page.isDisabled('#again'), 'a table has not the poses of its ticks');
  const read = await replayed();
  assert.ok(Math.abs(read.most - own.most) < 1e-6 && read.count > 10 && own.again === 0 && read.again === 0);
  fs.writeFileSync(path.join(folder, 'broken.csv'), fs.readFileSync(to, 'utf8').replace('force_N', 'farce'));
  await page.setInputFiles('#recording-file', path.join(folder, 'broken.csv'));
  await until(page, () => document.querySelector('#notice').textContent.includes('no recording'));
  assert.equal(await page.evaluate(() => window.sqmap.recorder.count), read.count, 'what was there stays');
});

test('a hand and a mesh of the scene touch as tools', async () => {
  const pushes = async () => {
    const f = await page.evaluate(() => ({ force: window.sqmap.frame().force, normal: window.sqmap.frame().normal }));
    assert.ok(f.force.reduce((sum, c, i) => sum + c * f.normal[i], 0) > 0, 'it pushes out');
  };
  await page.selectOption('#tool', 'hand');
  await until(page, () => window.sqmap.status().settings.tool === 'hand' && window.sqmap.world.tool.span() > 0.03);
  await feel(0, 0.1);
  await pushes();
  await page.screenshot({ path: path.join(folder, 'hand.png') });
  await page.mouse.up();
  await page.selectOption('#tool', '1');
  await until(page, () => window.sqmap.status().settings.tool === 1 && window.sqmap.world.objects.inHand === 1);
  const found = await page.evaluate(() => { const s = window.sqmap; for (let x = -1; x < 1; x += 0.05) for (let y = -1; y < 1; y += 0.05) if (s.world.cast(x, y)?.object === 1) return true; return false; });
  assert.equal(found, false, 'what is held is not there to be touched');
  await feel(0, 0.1);
  await pushes();
  await page.mouse.up();
  await page.selectOption('#tool', 'ball');
  await until(page, () => window.sqmap.status().settings.tool === 'ball' && window.sqmap.world.objects.inHand === -1);
});

test('the devices are listed with state, rate and limit', async () => {
  await page.click('#device-list summary');
  const rows = await page.$$eval('#devices tr', (r) => r.map((tr) => Array.from(tr.children, (c) => c.textContent)));
  assert.ok(rows.length > 1);
  assert.match(rows[0].join('|'), /simulated device\|✓ .*\|1000 Hz\|3\.3 N/);
  for (const row of rows) assert.ok(row.length === 4 && /^[✓–] ./.test(row[1]));
});

test('a tool that one window holds is not taken by another, and the sliders are felt while keys hold it', async () => {
  await page.focus('#stage');
  await page.keyboard.press('Enter');
  await until(page, () => window.sqmap.hand.holding && window.sqmap.status().touching);
  await page.focus('#s-friction');
  await page.waitForTimeout(100);
  assert.ok(await page.evaluate(() => window.sqmap.hand.holding), 'on the way to a slider it keeps touching');
  const other = await open();
  await other.click('#tab-touch');
  await other.focus('#stage');
  await other.keyboard.press('Enter');
  await until(other, () => /Another window has the tool/.test(document.querySelector('#notice').textContent));
  // Asked, it is taken over: the one that held it lets go.
  await other.keyboard.press('Enter');
  await other.click('#answer');
  await until(page, () => !window.sqmap.hand.holding);
  await other.focus('#stage');
  await other.keyboard.press('Enter');
  await until(other, () => window.sqmap.hand.holding && window.sqmap.status().touching);
  await other.close();
  await page.focus('#stage');
  await page.keyboard.press('Space');
  await until(page, () => window.sqmap.status().stopped && !window.sqmap.hand.holding);
  await page.click('#resume');
  await until(page, () => !window.sqmap.status().stopped);
});

test('a lost connection ends the force and is found again', async () => {
  const [x, y] = await onSurface(page, 0);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, () => window.sqmap.status().touching);
  await page.evaluate(() => window.sqmap.link.drop());
  await until(page, () => document.querySelector('#connection').textContent.includes('lost'));
  await until(page, () => document.querySelector('#connection').textContent === 'connected');
  // Still pressed: the tool is taken up again, off the surface first.
  await until(page, () => { const f = window.sqmap.frame(); return f !== null && f.engaged && f.contacts > 0; });
  await page.mouse.up();
});

test('parts are split, taken back, joined and baked', async () => {
  await page.click('#tab-look');
  await page.evaluate(() => window.sqmap.world.frame(1));
  await settled(page);
  const [x, y] = await onSurface(page, 1);
  await page.mouse.click(x, y);
  const count = () => page.evaluate(() => window.sqmap.facts()[1].parts.length);
  const before = await count();
  await page.click('#split');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  // The model would be that of the parts before: it is not given away as if it were of these.
  const [base, token] = url.split('?');
  assert.equal((await fetch(`${base}api/object/1/sqmap?${token}`)).status, 409);
  await inMenu(page, '#save-sqmap');
  await until(page, () => /Bake the edited parts first/.test(document.querySelector('#notice').textContent));
  assert.match(await page.textContent('#model-facts'), new RegExp(`torus: ${before + 1} parts, edited`));
  await page.click('#undo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n && !window.sqmap.facts()[1].edited, before);
  await page.click('#redo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  // A cut moves: what one part gains the other loses, and undo gives it back.
  const sizes = () => page.evaluate(() => window.sqmap.facts()[1].parts.map((p) => p.triangles));
  const s0 = await sizes();
  const [part, other] = await page.evaluate(() => [Array.from(document.querySelectorAll('.part')).findIndex((e) => e.getAttribute('aria-pressed') === 'true'), Number(document.querySelector('#other').value)]);
  for (const [button, sign] of [['#grow', 1], ['#shrink', -1]]) {
    await page.click(button);
    await until(page, ([p, n]) => window.sqmap.facts()[1].parts[p].triangles !== n, [part, s0[part]]);
    const s1 = await sizes();
    assert.ok(sign * (s1[part] - s0[part]) > 0);
    assert.equal(s1[part] + s1[other], s0[part] + s0[other]);
    await page.click('#undo');
    await until(page, ([p, n]) => window.sqmap.facts()[1].parts[p].triangles === n, [part, s0[part]]);
  }
  await page.click('#refit');
  await until(page, () => !window.sqmap.facts()[1].canRedo);
  assert.equal(await page.textContent('#connection'), 'connected');
  assert.equal(await count(), before + 1);
  await page.click('#undo');
  await until(page, () => window.sqmap.facts()[1].canRedo);
  await page.click('#merge');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before);
  await page.click('#undo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  await page.click('#bake');
  await until(page, (n) => !window.sqmap.facts()[1].edited && window.sqmap.facts()[1].parts.length === n, before + 1);
  const baked = await page.evaluate(() => window.sqmap.facts()[1]);
  assert.ok(baked.parts.every((p) => p.certified));
});

test('a part gets a name, which splits keep, a file holds, and touch speaks', async () => {
  const named = () => page.evaluate(() => window.sqmap.facts()[1].parts.findIndex((p) => p.name === 'tyre <b>'));
  const until_named = (yes) => until(page, (y) => window.sqmap.facts()[1].parts.some((p) => p.name === 'tyre <b>') === y, yes);
  await page.fill('#part-name', 'tyre <b>');
  await page.keyboard.press('Enter');
  await until_named(true);
  await page.click('#split');
  await until(page, () => window.sqmap.facts()[1].edited);
  assert.ok((await named()) >= 0);
  await page.click('#undo');
  await until(page, () => !window.sqmap.facts()[1].edited);
  const [download] = await Promise.all([page.waitForEvent('download'), inMenu(page, '#save-names')]);
  const file = path.join(folder, 'torus.names.json');
  await download.saveAs(file);
  assert.deepEqual(JSON.parse(fs.readFileSync(file)).names.map((n) => n.name), ['tyre <b>']);
  // Taken away, and given again by the file.
  await page.fill('#part-name', '');
  await page.keyboard.press('Enter');
  await until_named(false);
  await drop('torus.names.json', fs.readFileSync(file, 'utf8'));
  await until_named(true);
  await drop('torus.names.json', '{"names":[{"name":"x","at":[1,2]}]}');
  await page.waitForSelector('#verdict.bad');
  await page.click('#close-verdict');
  // Touched there, it is said.
  await page.evaluate(() => { window.said = []; const live = document.querySelector('#live'); new MutationObserver(() => window.said.push(live.textContent)).observe(live, { childList: true }); });
  await page.click('#tab-touch');
  await settled(page);
  const at = await page.evaluate((wanted) => {
    const s = window.sqmap, b = document.querySelector('#stage').getBoundingClientRect();
    for (let x = -0.95; x < 0.95; x += 0.03) for (let y = -0.95; y < 0.95; y += 0.03)
      if ([[0, 0], [0.03, 0], [-0.03, 0], [0, 0.03], [0, -0.03]].every(([u, v]) => { const h = s.world.cast(x + u, y + v); return h?.object === 1 && h.part === wanted; }))
        return [b.left + ((x + 1) / 2) * b.width, b.top + ((1 - y) / 2) * b.height];
    return null;
  }, await named());
  assert.ok(at, 'the part is in sight');
  await page.mouse.move(...at);
  await page.mouse.down();
  await until(page, () => window.said.some((t) => t.startsWith('tyre <b>')));
  await page.mouse.up();
  await page.click('#tab-look');
  await settled(page);
});

test('a bad mesh is refused with its reason and its cure', async () => {
  await drop('flat.off', 'OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n');
  await page.waitForSelector('#verdict.bad');
  assert.match(await page.textContent('#verdict'), /Not taken \(E_FLAT\).*What helps/s);
  await page.screenshot({ path: path.join(folder, 'refused.png') });
  assert.equal(await page.evaluate(() => window.sqmap.facts().length), 2);
});

test('a good mesh is baked, with progress, and stands beside the others', async () => {
  const file = path.join(folder, 'box.obj');
  execFileSync(sqmap, ['shapes', 'rounded_box', '-o', file]);
  await drop('box.obj', fs.readFileSync(file, 'utf8'));
  await page.waitForSelector('#verdict.good');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.objects.ready());
  const f = await page.evaluate(() => window.sqmap.facts()[2]);
  assert.equal(f.name, 'box');
  assert.ok(f.parts.length > 0 && f.parts.every((p) => p.certified));
});

test('a hole is filled, and the page says so', async () => {
  const lines = fs.readFileSync(path.join(folder, 'box.obj'), 'utf8').trim().split('\n');
  await drop('holed.obj', lines.slice(0, -1).join('\n') + '\n');  // a face short
  await page.waitForSelector('#verdict.good');
  assert.match(await page.textContent('#verdict'), /Taken, its holes closed.*filled_holes/s);
  await until(page, () => window.sqmap.facts().length === 4 && window.sqmap.world.objects.ready());
  // The model keeps what was made up, through another bake, too.
  const madeUp = () => page.evaluate(() => { let n = 0; for (let t = 0; t < window.sqmap.facts()[3].triangles; ++t) n += window.sqmap.world.objects.fieldAt(3, 'made-up', t); return n; });
  assert.match(await page.textContent('#facts'), /CLOSED: [\d.]+ % of the surface is made up; the rest moved by at most 0 % of its size/);
  await page.selectOption('#colour', 'made-up');
  await until(page, () => window.sqmap.world.objects.fieldAt(3, 'made-up', 0) !== undefined);
  const made = await madeUp();
  assert.ok(made > 0 && made < 10, `${made} triangles fill one missing face`);
  assert.match(await page.textContent('.legend'), /made up/);
  const last = await page.$$('#facts .object');
  await last[3].click();
  await page.screenshot({ path: path.join(folder, 'made-up.png') });
  await page.click('#panel details:has(.parts) summary');
  await page.click('.part');
  await page.click('#split');
  await until(page, () => window.sqmap.facts()[3].edited);
  await page.click('#bake');
  await until(page, () => !window.sqmap.facts()[3].edited && window.sqmap.world.objects.ready());
  assert.equal(await page.evaluate(() => window.sqmap.facts()[3].cure?.rung), 'CLOSED');
  await until(page, () => window.sqmap.world.objects.fieldAt(3, 'made-up', 0) !== undefined);
  assert.equal(await madeUp(), made);
  await page.selectOption('#colour', 'parts');
  await page.click('#remove');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.objects.ready());
});

test('an open mesh is taken as a surface when asked, and its fields are coloured', async () => {
  const lines = fs.readFileSync(path.join(folder, 'box.obj'), 'utf8').trim().split('\n');
  await drop('shell.obj', lines.slice(0, -400).join('\n') + '\n');
  await page.waitForSelector('#verdict.good #as-surface');
  await until(page, () => window.sqmap.facts().length === 4 && window.sqmap.world.objects.ready());
  await page.click('#as-surface');
  await page.waitForSelector('#verdict.good');
  // In place of what it was.
  await until(page, () => window.sqmap.facts().length === 4 && !window.sqmap.facts()[3].solid && window.sqmap.world.objects.ready());
  assert.equal(await page.inputValue('#repair'), '', 'the next file is read as before');
  for (const [kind, title] of [['protrusion', /Protrusion/], ['curvature', /curvature/], ['locales', /salient feature/], ['strength', /Boundary Strength/], ['regions', /Grey: not known/], ['error', /Depth error/]]) {
    await page.selectOption('#colour', kind);
    await until(page, (k) => window.sqmap.world.objects.fieldAt(3, k, 0) !== undefined, kind);
    await until(page, (t) => document.querySelector('.legend').textContent.includes(t), title.source);
  }
  await page.selectOption('#colour', 'parts');
  await (await page.$$('#facts .object'))[3].click();
  await page.click('#remove');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.objects.ready());
});

test('models are saved as GLB, JSON and .sqmap', async () => {
  for (const [kind, check] of [['glb', (b) => b.subarray(0, 4).toString() === 'glTF'], ['json', (b) => JSON.parse(b).parts.length > 0], ['sqmap', (b) => b.length > 1000]]) {
    const [download] = await Promise.all([page.waitForEvent('download'), inMenu(page, `#save-${kind}`)]);
    const to = path.join(folder, `saved.${kind}`);
    await download.saveAs(to);
    assert.ok(check(fs.readFileSync(to)), kind);
  }
  execFileSync(sqmap, ['info', path.join(folder, 'saved.sqmap')]);
  const glb = fs.readFileSync(path.join(folder, 'saved.glb')), root = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)));
  const parts = JSON.parse(fs.readFileSync(path.join(folder, 'saved.json'))).parts.length;
  const report = await gltf.validateBytes(new Uint8Array(glb));
  assert.deepEqual(report.issues.messages.filter((m) => m.severity < 2), [], "Khronos's validator finds no error and no warning");
  assert.equal(root.images.length, parts);
  assert.equal(root.materials.filter((m) => m.extras?.displacementTexture?.scale < 0).length, parts);
});

test('a link restores the view', async () => {
  await page.check('#superquadrics');
  await page.check('#spheres');
  await inMenu(page, '#link');
  const pose = await page.evaluate(() => window.sqmap.world.pose());
  const link = page.url();
  const other = await open();
  await other.goto('about:blank');
  await other.goto(link);
  await other.waitForSelector('body[data-ready]');
  const restored = await other.evaluate(() => window.sqmap.world.pose());
  restored.forEach((c, i) => assert.ok(Math.abs(c - pose[i]) < 2e-3));
  assert.ok((await other.isChecked('#superquadrics')) && (await other.isChecked('#spheres')) && !(await other.isChecked('#samples')));
  await other.close();
});

test('a link to a touch restores its settings', async () => {
  const set = (p, value) => p.evaluate((v) => { const e = document.querySelector('#s-stiffness'); e.value = String(v); e.dispatchEvent(new Event('input')); }, value);
  const stiffness = (p, value) => until(p, (v) => window.sqmap.status()?.settings.stiffness === v, value);
  const other = await open();
  await other.click('#tab-touch');
  const before = await other.evaluate(() => window.sqmap.status().settings.stiffness);
  await set(other, 700);
  await stiffness(other, 700);
  await inMenu(other, '#link');
  const link = other.url();
  await set(other, 250);
  await stiffness(other, 250);
  await other.goto('about:blank');
  await other.goto(link);
  await other.waitForSelector('body[data-ready]');
  await stiffness(other, 700);
  assert.equal(await other.getAttribute('#tab-touch', 'aria-selected'), 'true');
  await set(other, before);
  await stiffness(other, before);
  await other.close();
});

test('a round of recognition is played by keyboard alone', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  const tab = async (selector) => {
    for (let i = 0; i < 80; ++i) {
      if (await page.evaluate((s) => document.activeElement?.matches(s), selector)) return;
      await page.keyboard.press('Tab');
    }
    assert.fail(`${selector} is not reached with Tab`);
  };
  await tab('#tab-look');
  await page.keyboard.press('ArrowRight');
  await tab('#rounds');
  await page.keyboard.press('Home');  // four
  await tab('#begin');
  await page.keyboard.press('Enter');
  await until(page, () => window.sqmap.game.running);
  assert.ok(await page.evaluate(() => document.activeElement?.matches('#stage')), 'the keys that it names work at once');
  const objects = await page.evaluate(() => window.sqmap.facts().length), rounds = 5;  // one of them is practice
  await until(page, () => window.sqmap.world.shadows.every((s) => !s.plane.visible));  // it would tell what is hidden
  for (let round = 0; round < rounds; ++round) {
    const target = await page.evaluate(() => window.sqmap.game.target);
    if (round < 2) {
      await tab('#stage');
      await page.keyboard.press('Enter');
      for (let i = 0; i < 24; ++i) await page.keyboard.press(['ArrowLeft', 'ArrowUp', 'ArrowRight', 'ArrowDown'][i % 4]);
      // A torus has nothing in its middle: look for it beside, from one rim as far as to the other.
      for (let i = 0; i < 90 && !(await page.evaluate(() => window.sqmap.frame()?.contacts > 0)); ++i) { await page.keyboard.press('ArrowRight'); await page.waitForTimeout(60); }
      await until(page, () => window.sqmap.frame()?.contacts > 0);
      await page.screenshot({ path: path.join(folder, 'recognise.png') });
      // Asked, it says again what is touched, whatever Caps Lock does; of a hidden object parts have numbers, not names.
      // A light touch may end between the two; then it says so, and is felt for again.
      for (let i = 0; ; ++i) {
        await page.evaluate(() => { document.querySelector('#live').textContent = ''; });
        await page.keyboard.press('N');
        const said = await until(page, () => { const t = document.querySelector('#live').textContent; return /^part \d+, (new|touched before), \d\.\d newtons|^Touching nothing/.test(t) && t; });
        if (/newtons/.test(await said.jsonValue())) break;
        assert.ok(i < 20, 'what is touched is said');
        await page.keyboard.press('ArrowRight');
        await page.waitForTimeout(60);
      }
      assert.ok((await page.isChecked('#panel #sound')) && (await page.isChecked('#panel #voice')));
      // The hidden object is nowhere told.
      const name = await page.evaluate((t) => window.sqmap.facts()[t].name, target);
      assert.ok(!(await page.textContent('#force')).includes(name) && await page.isHidden('#facts'));
      await page.keyboard.press('Enter');
      await until(page, () => window.sqmap.frame().contacts === 0);  // till then Space stops
    }
    if (round === 1) await page.selectOption('#confidence', '4');
    await tab('input[name=guess]');
    // Right in all rounds but the last.
    const wanted = round < rounds - 1 ? target : (target + 1) % objects;
    await page.keyboard.press('Space');
    for (let i = 0; i < objects && !(await page.isChecked(`input[name=guess][value="${wanted}"]`)); ++i) await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#answer-words');
    assert.match(await page.textContent('#answer-words'), round < rounds - 1 ? /Right: it is/ : /Wrong: it was/);
    assert.ok(await page.evaluate(() => document.activeElement?.matches('#next') && !window.sqmap.world.objects.hidden), 'what was felt is shown, and Enter goes on');
    await page.keyboard.press('Enter');
  }
  assert.match(await page.textContent('#score'), /^3 of 4 right/);
  const rows = (await page.evaluate(() => window.sqmap.game.results())).trim().split('\n');
  assert.equal(rows.length, rounds + 1);
  assert.match(rows[0], /^participant,date,round,practice,object,hash,guess,right,confidence,seconds,servo_seconds,touched_seconds/);
  const cells = rows[2].split(',');
  assert.deepEqual(rows.slice(1, 4).map((r) => r.split(',')[8]), ['', '4', '']);
  assert.ok(Number(cells[11]) > 0 && Number(cells[10]) >= Number(cells[11]), 'time in touch is the servo\'s');
  assert.deepEqual(rows.slice(1).map((r) => r.split(',')[3]), ['1', '0', '0', '0', '0']);
});

test('a figure is dressed: cloth is pulled, pinned, cut and changed', async () => {
  if (await page.isHidden('#tab-dress')) { console.log('      (this program was built without cloth)'); return; }
  await page.click('#tab-dress');
  await settled(page);
  await dressed(page);
  const finite = () => page.evaluate(() => window.sqmap.costume.last.positions.every((x) => Number.isFinite(x) && Math.abs(x) < 5));
  assert.ok(await finite());
  const low = await page.evaluate(() => { const p = window.sqmap.costume.last.positions; let y = 9; for (let i = 1; i < p.length; i += 3) y = Math.min(y, p[i]); return y; });
  assert.ok(low > 0.4, 'the shirt hangs on the figure');
  await page.screenshot({ path: path.join(folder, 'dress.png') });
  // Pulled to the side it pulls back.
  const b = await (await page.$('#stage')).boundingBox();
  let at = null;
  for (let y = 0.4; y < 0.65 && !at; y += 0.02) {
    await page.mouse.move(b.x + 0.5 * b.width, b.y + y * b.height);
    await page.mouse.down();
    if (await page.evaluate(() => window.sqmap.costume.held)) at = y; else await page.mouse.up();
  }
  assert.ok(at, 'there is cloth in the middle of the view');
  await until(page, () => window.sqmap.costume.last.held);
  await page.mouse.move(b.x + 0.62 * b.width, b.y + at * b.height, { steps: 12 });
  await until(page, () => window.sqmap.costume.last.held && Math.hypot(...window.sqmap.costume.last.tension) > 0.2);
  await until(page, () => /Pull\d/.test(document.querySelector('#cloth-facts').textContent));
  await page.screenshot({ path: path.join(folder, 'pull.png') });
  await page.mouse.up();
  await until(page, () => !window.sqmap.costume.last.held);
  await page.check('#grip-pin');
  await page.mouse.click(b.x + 0.5 * b.width, b.y + at * b.height);
  await until(page, () => window.sqmap.costume.last.pinned > 0);
  await page.click('#unpin');
  await until(page, () => window.sqmap.costume.last.pinned === 0);
  // Cut along a line, by the pointer and by keys; the vertices on it are doubled, and sewn again.
  const vertices = () => page.evaluate(() => window.sqmap.costume.last.positions.length / 3);
  const cut = async (n, act) => {
    const had = await vertices();
    await act();
    await until(page, ([k, v]) => window.sqmap.status().cloth.worn.seams.some((s) => s.name === `cut ${k}` && !s.sewn) && window.sqmap.costume.last.positions.length / 3 > v, [n, had]);
  };
  await page.check('#grip-cut');
  await cut(1, async () => {
    await page.mouse.move(b.x + 0.5 * b.width, b.y + at * b.height);
    await page.mouse.down();
    await page.mouse.move(b.x + 0.49 * b.width, b.y + (at - 0.1) * b.height, { steps: 10 });
    await page.screenshot({ path: path.join(folder, 'cut.png') });
    await page.mouse.up();
  });
  await cut(2, async () => {
    await page.focus('#stage');
    for (let i = 0; i < 2; ++i) await page.keyboard.press('ArrowRight');
    await page.keyboard.press('c');
    for (let i = 0; i < 10; ++i) await page.keyboard.press('Shift+ArrowDown');
    await page.keyboard.press('c');
  });
  // As it stands, cut and all, it is saved as GLB.
  const [download] = await Promise.all([page.waitForEvent('download'), inMenu(page, '#save-figure')]);
  const to = path.join(folder, 'figure.glb');
  await download.saveAs(to);
  const glb = fs.readFileSync(to), root = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)));
  assert.deepEqual((await gltf.validateBytes(new Uint8Array(glb))).issues.messages.filter((m) => m.severity < 2), [], "Khronos's validator finds no error and no warning");
  assert.equal(root.meshes.length, 2, 'the figure and the cloth');
  assert.ok(root.accessors.some((a) => a.type === 'VEC3' && a.count > 300 && a.max?.[1] > 1), 'the cloth is where the figure wears it');
  await page.evaluate(() => { document.querySelector('#export').open = false; });
  await page.click('#seam-cut-1');
  await until(page, () => window.sqmap.status().cloth.worn.seams.some((s) => s.name === 'cut 1' && s.sewn));
  assert.ok(await finite());
  await page.click('#seam-sides');
  await until(page, () => window.sqmap.status().cloth.worn.seams.some((s) => s.name === 'sides' && !s.sewn));
  await until(page, () => window.sqmap.costume.last.gap > 0.01);
  await page.selectOption('#fabric', 'leather');
  await until(page, () => window.sqmap.status().cloth.worn.fabric === 'leather');
  assert.ok(await page.evaluate(() => !window.sqmap.status().cloth.worn.seams.find((s) => s.name === 'sides').sewn), 'another fabric keeps what was cut');
  const number = await page.evaluate(() => window.sqmap.costume.last.number);
  await page.selectOption('#garment', 'skirt');
  await until(page, (n) => window.sqmap.status().cloth.worn.garment === 'skirt' && window.sqmap.costume.last.number > n, number);
  const arm = await page.evaluate(() => Array.from(window.sqmap.costume.last.poses.subarray(12 * 3, 12 * 3 + 9)));
  await page.check('#walks');
  await until(page, (r) => r.some((x, i) => Math.abs(x - window.sqmap.costume.last.poses[12 * 3 + i]) > 0.3), arm);
  assert.ok(await finite());
  await page.click('#tab-look');
  await until(page, () => window.sqmap.status().cloth.worn === null);
  // The figure is still there.
  const frames = await page.evaluate(() => window.sqmap.costume.frames);
  await page.click('#tab-dress');
  await until(page, (n) => window.sqmap.costume.frames > n + 2, frames);
  assert.ok(await page.isHidden('#progress'));
  await page.click('#tab-look');
  await until(page, () => window.sqmap.status().cloth.worn === null);
  await settled(page);
});

test('high contrast reaches the page and the stage', async () => {
  for (let i = 0; i < 3 && (await page.evaluate(() => document.documentElement.dataset.theme)) !== 'contrast'; ++i) await page.click('#theme');
  assert.deepEqual(await page.evaluate(() => [getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]), ['rgb(0, 0, 0)', 'rgb(255, 255, 255)']);
  assert.match(await page.getAttribute('#theme', 'aria-label'), /High contrast/);
  await page.screenshot({ path: path.join(folder, 'contrast.png') });
  await page.click('#theme');
});

test('nothing overflows, light and dark, narrow and wide', async () => {
  for (const [name, width, height, colorScheme] of [['wide-light', 1360, 820, 'light'], ['wide-dark', 1360, 820, 'dark'], ['narrow-light', 390, 844, 'light'], ['narrow-dark', 390, 844, 'dark']]) {
    const other = await open({ viewport: { width, height }, colorScheme });
    for (const mode of ['look', 'touch', 'recognise', ...(name === 'narrow-dark' && (await other.isVisible('#tab-dress')) ? ['dress'] : [])]) {
      await other.click(`#tab-${mode}`);
      await other.waitForTimeout(250);
      assert.ok(await other.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name} ${mode}`);
      assert.ok(width < 820 || (await other.evaluate(() => document.documentElement.scrollHeight <= innerHeight)), `${name} ${mode}: the page does not scroll`);
      assert.equal(await other.isVisible('#stop'), mode !== 'look', 'STOP is where something can be felt');
      if (mode === 'look') { await other.screenshot({ path: path.join(folder, `${name}-${mode}.png`) }); continue; }
      const box = await (await other.$('#stop')).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= width && box.width * box.height > 2000, 'STOP is in sight');
      await other.screenshot({ path: path.join(folder, `${name}-${mode}.png`) });
    }
    await other.close();
  }
});

await run(() => page);
