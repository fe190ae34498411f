// Tests what a user relies on without looking for it: the force follows the sliders, thin plates hold, STOP drops a pull; and the tools
// beside: queue, orders of a study, panel, pictures, colours, charts.
// usage: node tools_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { browser, dressed, drop, feel, folder, onSurface, openPage, run, settled, sqmap, start, test, until } from './harness.mjs';

const { url } = await start();
const wide = { viewport: { width: 1360, height: 800 } };
let page = await openPage(url, wide);

const press = (mm) => page.evaluate((x) => { window.sqmap.hand.press = x / 1000; window.sqmap.hand.deeper(0); }, mm);
/// A frame once the force stands still; null where a busy machine has ended it.
const still = async () => {
  await page.evaluate(() => { window.same = 0; window.before = -1; });  // what stood still before does not count
  await page.waitForTimeout(150);
  const found = await until(page, () => {
    const s = window.sqmap, f = s.frame();
    if (!f || f.faults || (f.contacts > 0 && !f.engaged)) return 'none';
    const force = Math.hypot(...f.force), same = f.contacts > 0 && Math.abs(force - window.before) < 0.002;
    window.same = same ? window.same + 1 : 0;
    window.before = force;
    return window.same > 12 && { force, depth: f.depth, limit: s.status().limit, push: f.force.reduce((sum, x, i) => sum + x * f.normal[i], 0), tool: f.tool, hand: f.hand };
  });
  const frame = await found.jsonValue();
  return frame === 'none' ? null : frame;
};
/// Pressed so deep on an object.
const pressed = async (object, mm) => {
  for (let tries = 0; tries < 8; ++tries) {
    if (!(await page.evaluate(() => window.sqmap.hand.holding))) await feel(page, object, 0.02);
    await press(mm);
    const frame = await still();
    if (frame) return frame;
    await page.mouse.up();
    await page.waitForTimeout(300);
  }
  assert.fail('the servo keeps finding faults');
};
const set = async (key, id, value) => { await page.locator(id).fill(String(value)); await until(page, ([k, v]) => window.sqmap.status().settings[k] === v, [key, value]); };

test('the force is the stiffness times the depth up to the limit shown, and a harder press is never softer', async () => {
  await settled(page);
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  for (const stiffness of [100, 500, 1500]) {
    await set('stiffness', '#s-stiffness', stiffness);
    let before = 0;
    for (const mm of [2, 6, 12]) {
      const f = await pressed(0, mm), wanted = Math.min(stiffness * f.depth, f.limit);
      assert.ok(Math.abs(f.force - wanted) < 0.05 * wanted, `${stiffness} N/m, ${mm} mm: ${f.force} N, wanted ${wanted}`);
      assert.ok(f.force > before - 0.01, `${f.force} N after ${before} N`);
      before = f.force;
    }
    assert.ok(stiffness < 1500 || Math.abs(before - 2) < 0.02, `the limit of 2 N is reached: ${before} N`);
    await page.mouse.up();
  }
  await set('stiffness', '#s-stiffness', 500);
});

test('a plate of a millimetre holds a press of 12 mm, and the touch does not overshoot', async () => {
  // Its size, the diagonal, becomes 200 mm.
  await drop(page, ['flat.off', 'OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n']);
  await page.waitForSelector('#verdict.bad');  // which opens the choices
  await page.fill('#thickness', String(0.001 * (Math.SQRT2 / 0.2)));
  await drop(page, ['plate.obj', 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n']);
  await until(page, () => window.sqmap.facts().some((f) => f.name === 'plate') && window.sqmap.world.objects.ready());
  const plate = await page.evaluate(() => window.sqmap.facts().findIndex((f) => f.name === 'plate'));
  await page.fill('#thickness', '');
  await page.click('#close-verdict');
  const { half, position } = await page.evaluate((i) => window.sqmap.facts()[i], plate);
  assert.ok(Math.abs(2 * half[2] - 0.001) < 1e-4, `${2 * half[2]} m thick`);
  await page.evaluate((i) => window.sqmap.world.frame(i), plate);
  await settled(page);
  await page.click('#record');
  const f = await pressed(plate, 12), side = Math.sign(f.tool[2] - position[2]);
  assert.ok(f.push > 0.5 && side * (f.tool[2] - position[2]) > 0.005, 'on the side that it came from');
  assert.ok(side * (f.hand[2] - position[2]) < 0.005, 'the hand is below');
  await page.mouse.up();
  await page.click('#record');
  // The first touch, of all ticks: as deep as it comes to rest, and no deeper.
  const felt = await page.evaluate(() => { const out = []; for (const { frame } of window.sqmap.recorder.kept) if (frame.contacts > 0) out.push({ depth: frame.depth, push: frame.force.reduce((sum, x, i) => sum + x * frame.normal[i], 0) }); return out; });
  assert.ok(felt.length > 5 && felt.every((x) => x.push > -0.01), `it never pulls through: ${felt.length} frames, ${JSON.stringify(felt.filter((x) => x.push <= -0.01))}`);
  assert.ok(Math.max(...felt.map((x) => x.depth)) <= 1.1 * f.depth, `no overshoot: ${Math.max(...felt.map((x) => x.depth))} of ${f.depth} m`);
});

test('charts and stage have one moment: a click on a chart moves the replay there', async () => {
  const seconds = await page.evaluate(() => window.sqmap.recorder.seconds);
  await page.locator('#scrub').fill(String(Math.floor(10 * seconds) / 10));
  await page.hover('.chart-box', { position: { x: 120, y: 40 } });
  assert.equal(await page.evaluate(() => document.querySelectorAll('.cursor:not([hidden])').length), 4, 'one line through all charts');
  const before = await page.evaluate(() => window.sqmap.recorder.position), box = await (await page.$('.chart-box')).boundingBox();
  await page.click('.chart-box', { position: { x: 0.9 * box.width, y: 40 } });
  const after = await page.evaluate(() => window.sqmap.recorder.position);
  assert.ok(after < before && after > before - 2, `${before} to ${after}`);
  await page.click('#to-now');
});

test('a tool that is let go is never caught: the force ends, whatever lies between it and the hand', async () => {
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  await pressed(0, 6);
  await page.mouse.up();
  await until(page, () => window.sqmap.frame().contacts === 0);
  await pressed(0, 6);
  // Let go with the hand on the other side of the object.
  await page.evaluate(() => {
    const { frame, link, hand } = window.sqmap, f = frame();
    hand.held = hand.drags = false;
    link.say({ say: 'touch', p: f.tool.map((x, i) => Number((x - 0.1 * f.normal[i]).toFixed(6))), held: false });
  });
  await page.waitForTimeout(200);
  await until(page, () => window.sqmap.frame().contacts === 0 && Math.hypot(...window.sqmap.frame().force) === 0);
  await page.mouse.up();
});

test('contact, limit and fault are marked on the timeline', async () => {
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  await page.click('#record');
  await pressed(0, 12);
  await page.keyboard.press('Space');
  await until(page, () => window.sqmap.status().stopped && window.sqmap.frame().faults !== 0);
  await page.mouse.up();
  await page.click('#resume');
  await until(page, () => !window.sqmap.status().stopped);
  await page.click('#record');
  const kinds = await page.evaluate(() => window.sqmap.recorder.spans().map((m) => m.kind));
  assert.deepEqual([...new Set(kinds)], ['contact', 'limit', 'fault']);
  assert.deepEqual(await page.$$eval('.marks i', (all) => all.map((e) => e.className)), kinds);
});

test('a file that waits in the queue is taken out of it', async () => {
  const file = path.join(folder, 'torus.obj');
  execFileSync(sqmap, ['shapes', 'torus', '-o', file]);
  const text = fs.readFileSync(file, 'utf8'), count = await page.evaluate(() => window.sqmap.facts().length);
  await drop(page, ['first.obj', text], ['second.obj', text]);
  // It has been sent, and waits in the program for the bake before it.
  await until(page, () => /second\.obj\s*checking/.test(document.querySelector('#queue').textContent));
  await page.evaluate(() => document.querySelector('[aria-label="Cancel second.obj"]').click());
  assert.match(await page.textContent('#queue'), /second\.obj\s*cancelled/);
  await drop(page, ['third.obj', text]);
  // The bake at hand goes on: it is another file's.
  await until(page, (n) => window.sqmap.facts().length === n + 2 && document.querySelector('#progress').hidden, count);
  assert.deepEqual(await page.evaluate((n) => window.sqmap.facts().slice(n).map((f) => f.name), count), ['first', 'third']);
  assert.match(await page.textContent('#queue'), /first\.obj\s*✓.*second\.obj\s*cancelled.*third\.obj\s*✓/s);
  assert.match(await page.textContent('#verdict'), /64 MB and 500,000 faces/);
  await page.click('#close-verdict');
});

test('orders of a study are balanced over participants', async () => {
  await page.click('#tab-recognise');
  await page.uncheck('#practice');
  await page.selectOption('#order', 'balanced');
  await page.selectOption('#rounds', '8');
  const n = await page.evaluate(() => window.sqmap.facts().length), orders = [];
  for (let k = 0; k < 2 * n; ++k) {
    await page.fill('#participant', `P${k}`);
    await page.click('#begin');
    orders.push(await page.evaluate((m) => window.sqmap.game.order.slice(0, m), n));
    await page.click('text=Leave the game');
  }
  const count = (pairs) => { const out = new Map(); for (const p of pairs) out.set(String(p), (out.get(String(p)) ?? 0) + 1); return out; };
  for (const order of orders) assert.deepEqual([...order].sort(), Array.from({ length: n }, (_, i) => i).slice(0, order.length), 'each object once');
  const first = count(orders.map((o) => o[0])), follows = count(orders.flatMap((o) => o.slice(1).map((x, i) => [o[i], x])));
  assert.deepEqual([first.size, new Set(first.values()).size, follows.size, new Set(follows.values()).size], [n, 1, n * (n - 1), 1], 'everything is first, and follows everything else, equally often');
});

test('the panel is as wide as the user wants, and on a narrow screen a sheet that slides', async () => {
  await page.click('#tab-look');
  const width = () => page.evaluate(() => document.querySelector('#panel').getBoundingClientRect().width);
  const before = await width();
  await page.focus('.edge');
  await page.keyboard.press('ArrowLeft');
  assert.ok(Math.abs((await width()) - before - 20) < 2);
  const edge = await (await page.$('.edge')).boundingBox();
  await page.mouse.move(edge.x + 3, 400);
  await page.mouse.down();
  await page.mouse.move(edge.x - 97, 400, { steps: 4 });
  await page.mouse.up();
  assert.ok(Math.abs((await width()) - before - 120) < 8, `${await width()} after ${before}`);
  const small = await openPage(url, { viewport: { width: 390, height: 844 } });
  assert.ok(await small.evaluate(() => document.querySelector('#panel').inert));
  const stage = await (await small.$('#stage')).boundingBox();
  assert.ok(stage.height > 400, 'the stage comes first');
  await small.click('#sheet');
  await until(small, () => { const b = document.querySelector('#panel').getBoundingClientRect(); return !document.querySelector('#panel').inert && b.top < innerHeight - 200 && b.left >= 0 && b.right <= innerWidth; });
  await small.click('#sheet');
  await until(small, () => document.querySelector('#panel').inert);
  await small.close();
});

test('a picture has the width that was chosen', async () => {
  await page.evaluate(() => { document.querySelector('#export').open = true; });
  const taken = {};
  for (const width of ['1920', '7680']) {
    await page.selectOption('#picture-width', width);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#picture')]);
    taken[width] = path.join(folder, `picture-${width}.png`);
    await download.saveAs(taken[width]);
    assert.equal(fs.readFileSync(taken[width]).readUInt32BE(16), Number(width));
  }
  // Its tiles are one picture, that of the smaller one.
  const beside = await browser.newPage(), apart = await beside.evaluate(async (pair) => {
    const pixels = await Promise.all(pair.map(async (text) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${text}`)).blob()), c = new OffscreenCanvas(480, 300).getContext('2d');
      c.imageSmoothingQuality = 'high';
      c.drawImage(image, 0, 0, 480, 300);
      return c.getImageData(0, 0, 480, 300).data;
    }));
    let far = 0;
    for (let k = 0; k < pixels[0].length; k += 4) if (Math.abs(pixels[0][k] - pixels[1][k]) > 40) ++far;
    return far / (480 * 300);
  }, Object.values(taken).map((file) => fs.readFileSync(file).toString('base64')));
  await beside.close();
  assert.ok(apart < 0.01, `${100 * apart} % of it differs`);
  await settled(page);
  await page.evaluate(() => { document.querySelector('#export').open = false; });
});

test('a wireframe, and words of users: equations stand in tooltips', async () => {
  await page.selectOption('#surface', 'wire');
  assert.ok(await page.evaluate(() => window.sqmap.world.objects.surfaces().every((m) => [m.material].flat().every((x) => x.wireframe))));
  await page.selectOption('#surface', 'solid');
  await page.check('#axes');
  assert.ok(await page.evaluate(() => window.sqmap.world.axes.parent !== null));
  await page.uncheck('#axes');
  for (const tab of ['touch', 'look']) {
    await page.click(`#tab-${tab}`);
    await page.evaluate(() => document.querySelectorAll('#panel details').forEach((d) => { d.open = true; }));
    const text = await page.evaluate(() => document.querySelector('#panel').innerText);
    assert.ok(!/\beqs?\.|R_max|\bQ2\b|eq\. 12/.test(text), tab);
    if (tab === 'look') assert.match(text, /Bounding spheres.*Contact margin.*Hidden surface/s);
  }
});

test('neighbouring parts differ in colour, the ball is seen on all, and controls have edges: 3 to 1', async () => {
  await page.click('#tab-look');
  const found = await page.evaluate(() => {
    const linear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4), light = (c) => { const [r, g, b] = c.map(linear); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const ratio = (a, b) => { const [low, high] = [light(a), light(b)].sort((x, y) => x - y); return (high + 0.05) / (low + 0.05); };
    const lab = (c) => {
      const [r, g, b] = c.map(linear), f = (t) => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
      const [x, y, z] = [f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505), f(0.2126 * r + 0.7152 * g + 0.0722 * b), f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089)];
      return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
    };
    const s = window.sqmap, black = [0x14, 0x18, 0x1d].map((x) => x / 255), white = [1, 1, 1];
    let ball = 99, apart = 999;
    s.facts().forEach((f, o) => f.parts.forEach((p, i) => {
      const own = s.world.objects.colourOf(o, i);
      ball = Math.min(ball, Math.max(ratio(own, black), ratio(own, white)));
      for (const n of p.neighbours) apart = Math.min(apart, Math.hypot(...lab(own).map((x, k) => x - lab(s.world.objects.colourOf(o, n))[k])));
    }));
    const rgb = (text) => text.match(/[\d.]+/g).slice(0, 3).map((x) => x / 255);
    const controls = [];
    for (const e of document.querySelectorAll('button, .button, select, input[type=text], input[type=number]')) {
      if (!e.checkVisibility() || e.disabled) continue;
      const style = getComputedStyle(e);
      if (style.borderTopStyle === 'none' || style.borderTopWidth === '0px' || style.borderTopColor === 'rgba(0, 0, 0, 0)') continue;
      let on = e.parentElement;
      while (on.parentElement && getComputedStyle(on).backgroundColor === 'rgba(0, 0, 0, 0)') on = on.parentElement;
      const under = rgb(getComputedStyle(on).backgroundColor), best = Math.max(ratio(rgb(style.borderTopColor), under), style.backgroundColor === 'rgba(0, 0, 0, 0)' ? 0 : ratio(rgb(style.backgroundColor), under));
      if (best < 3) controls.push(`${e.id || e.textContent} ${best.toFixed(2)}`);
    }
    return { ball, apart, controls };
  });
  assert.ok(found.ball >= 3, `the ball: ${found.ball}`);
  assert.ok(found.apart > 20, `neighbours: ${found.apart}`);
  assert.deepEqual(found.controls, []);
});

test('a contact sounds with the modes of the material, at a pitch of the size', async () => {
  await page.evaluate(() => {
    window.struck = [];
    const stop = OscillatorNode.prototype.stop;
    // The tones that tell the tool's height last 0.08 s each; all others are modes.
    OscillatorNode.prototype.stop = function (at) {
      const lasts = at - this.context.currentTime;
      if (Math.abs(lasts - 0.08) > 1e-4) window.struck.push({ pitch: this.frequency.value, lasts });
      stop.call(this, at);
    };
  });
  await page.click('#tab-touch');
  await settled(page);
  if (!(await page.evaluate(() => document.querySelector('#panel #sound').checked))) await page.click('#sound-button');
  const size = 2 * Math.max(...(await page.evaluate(() => window.sqmap.facts()[0].half)));
  const heard = {};
  for (const material of ['wood', 'rubber']) {
    await page.selectOption('#material', material);
    await page.evaluate(() => { window.struck.length = 0; });
    await feel(page, 0, 0.02);
    await until(page, () => window.struck.length > 0);
    await page.mouse.up();
    heard[material] = await page.evaluate(() => window.struck.slice(0, 4));
  }
  await page.selectOption('#material', { index: 0 });
  // The modes of a free bar, of which the lowest is the wave's speed over the size, and sounds longest.
  assert.ok(Math.abs(heard.wood[0].pitch * size - 85) < 1, `${heard.wood[0].pitch} Hz at ${size} m`);
  [1, 2.76, 5.4, 8.93].forEach((ratio, k) => assert.ok(Math.abs(heard.wood[k].pitch / heard.wood[0].pitch - ratio) < 0.01));
  for (const modes of Object.values(heard)) for (let k = 1; k < modes.length; ++k) assert.ok(modes[k].lasts <= modes[k - 1].lasts);
  assert.ok(heard.wood[0].pitch > 2 * heard.rubber[0].pitch, 'wood is higher than rubber');
  assert.ok(heard.wood[0].lasts > heard.rubber[0].lasts, 'and rings longer');
});

test('STOP in Dress drops the pull and its number', async () => {
  if (await page.isHidden('#tab-dress')) { console.log('      (this program was built without cloth)'); return; }
  await page.click('#tab-dress');
  await settled(page);
  await dressed(page);
  const b = await (await page.$('#stage')).boundingBox();
  // The figure walks: cloth is looked for anew each time.
  const take = async () => {
    for (let y = 0.4; y < 0.65; y += 0.02) {
      await page.mouse.move(b.x + 0.5 * b.width, b.y + y * b.height);
      await page.mouse.down();
      if (await page.evaluate(() => window.sqmap.costume.held)) return y;
      await page.mouse.up();
    }
    return null;
  };
  const at = await take();
  assert.ok(at, 'there is cloth in the middle of the view');
  await page.mouse.move(b.x + 0.62 * b.width, b.y + at * b.height, { steps: 12 });
  await until(page, () => /Pull[\d.]+ N/.test(document.querySelector('#cloth-facts').textContent));
  await page.keyboard.press('Space');
  await until(page, () => !window.sqmap.costume.held && !window.sqmap.costume.last.held);
  await until(page, () => /Pullnothing held/.test(document.querySelector('#cloth-facts').textContent));
  await page.mouse.up();
  // As elsewhere: nothing is taken until Resume, which has the focus.
  await until(page, () => document.activeElement.id === 'resume' && window.sqmap.status().stopped);
  await page.focus('#stage');
  await page.keyboard.press('Enter');
  assert.ok(!(await page.evaluate(() => window.sqmap.costume.held)));
  await page.focus('#resume');
  await page.keyboard.press('Enter');
  await until(page, () => !window.sqmap.status().stopped);
  assert.ok(await take(), 'cloth is taken again after Resume');
  await page.mouse.up();
});

await run(() => page);
