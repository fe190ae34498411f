// The page of `sqmap view` in Chromium: what a person would do, and what the program says beside it.
// usage: node page_test.mjs SQMAP CHROMIUM FOLDER     screenshots go to FOLDER; exit 0 where every claim holds
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [, , sqmap, chromium, folder] = process.argv;
const web = path.join(path.dirname(fileURLToPath(import.meta.url)), '../../apps/viewer/web/');
const { chromium: browserType } = createRequire(web)('playwright-core');
fs.rmSync(folder, { recursive: true, force: true });
fs.mkdirSync(folder, { recursive: true });

const program = spawn(sqmap, ['view'], { stdio: ['ignore', 'pipe', 'inherit'] });
process.on('exit', () => program.kill());
const url = await new Promise((resolve, reject) => {
  let text = '';
  program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); });
  program.on('exit', (code) => reject(new Error(`sqmap view ended with ${code}`)));
});

// Software rendering: the machine that tests has no graphics card.
const browser = await browserType.launch({ executablePath: chromium, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const complaints = [];
async function open(options = {}) {
  const page = await browser.newPage({ viewport: { width: 1100, height: 720 }, colorScheme: 'light', acceptDownloads: true, ...options });
  page.setDefaultTimeout(30000);
  page.on('pageerror', (e) => complaints.push(e.message));
  page.on('console', (m) => { if (m.type() === 'error' && !/ERR_|WebSocket|Failed to load resource/.test(m.text())) complaints.push(m.text()); });
  await page.goto(url);
  await page.waitForSelector('body[data-ready]');
  return page;
}

const tests = [];
const test = (name, body) => tests.push([name, body]);
const until = async (page, what, arg) => page.waitForFunction(what, arg, { timeout: 30000, polling: 50 });
/// Once the stage has the size that its mode gives it.
const settled = async (page) => {
  await until(page, () => {
    const c = document.querySelector('#stage'), b = c.parentElement.getBoundingClientRect();
    return Math.abs(c.width / Math.min(devicePixelRatio, 2) - b.width) < 2 && Math.abs(c.height / Math.min(devicePixelRatio, 2) - b.height) < 2;
  });
  await page.waitForTimeout(100);
};
/// A place of the screen where an object's surface faces the eye.
const onSurface = (page, object) => page.evaluate((i) => {
  const s = window.sqmap, f = s.facts()[i], b = document.querySelector('#stage').getBoundingClientRect();
  const q = s.world.project(s.world.controls.target.clone().set(...f.place));
  for (let r = 0; r < 0.6; r += 0.02)
    for (let a = 0; a < 6.28; a += 0.5) {
      const x = q.x + r * Math.cos(a), y = q.y + r * Math.sin(a), hit = s.world.cast(x, y, i);
      if (hit) return [b.left + ((x + 1) / 2) * b.width, b.top + ((1 - y) / 2) * b.height];
    }
  return null;
}, object);

let page;

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
  assert.ok(await page.evaluate(() => window.sqmap.world.ready()));
});

test('a click tells the numbers of the place and the part, and its map marks the place', async () => {
  const [x, y] = await onSurface(page, 0);
  await page.mouse.click(x, y);
  await until(page, () => document.querySelector('#numbers').textContent.includes('Triangle'));
  await page.waitForSelector('.map-canvas:not([hidden])');
  await page.mouse.move(x + 1, y);
  await until(page, () => /mm below the superquadric$/.test(document.querySelector('.map-words').textContent));
  // And the other way: pointing at the map's middle marks a place of the surface.
  await page.hover('.map-canvas', { position: { x: 60, y: 130 } });
});

test('fields are coloured with a legend', async () => {
  await page.selectOption('#colour', 'error');
  await page.waitForSelector('.legend:not([hidden])');
  assert.match(await page.textContent('.legend'), /Depth error/);
  await page.screenshot({ path: path.join(folder, 'error.png') });
  await page.selectOption('#colour', 'parts');
});

test('a drag is felt: force, arrow and trace agree', async () => {
  await page.click('#tab-touch');
  await settled(page);
  const [x, y] = await onSurface(page, 0);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, () => { const f = window.sqmap.frame(); return f && f.engaged && f.contacts > 0 && Math.hypot(...f.force) > 0.2; });
  await page.mouse.move(x + 3, y + 2, { steps: 3 });
  await page.waitForTimeout(700);
  const felt = await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => {
    const s = window.sqmap, f = s.frame();
    resolve({ force: f.force, normal: f.normal, depth: f.depth, object: f.object, arrow: s.world.arrowNow(), chart: [s.charts.latest(0), s.charts.latest(1)], words: document.querySelector('#force').textContent });
  })));
  const size = Math.hypot(...felt.force), unit = felt.force.map((c) => c / size);
  assert.equal(felt.object, 0);
  assert.ok(felt.arrow.visible && Math.abs(felt.arrow.length - 0.03 * size) < 1e-6);
  felt.arrow.direction.forEach((c, i) => assert.ok(Math.abs(c - unit[i]) < 1e-3));
  assert.ok(Math.abs(felt.chart[0] - size) < 1e-3, `${felt.chart[0]} against ${size}`);
  assert.ok(Math.abs(felt.chart[1] - 1000 * felt.depth) < 1e-3);
  // The push is outwards: within the friction cone about the normal.
  assert.ok(unit.reduce((sum, c, i) => sum + c * felt.normal[i], 0) > Math.cos(Math.atan(0.4) + 0.1));
  assert.match(felt.words, /N · .* mm deep/);
  await page.screenshot({ path: path.join(folder, 'touch.png') });
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
});

test('sliders reach the program', async () => {
  await page.locator('#s-stiffness').fill('800');
  await until(page, () => window.sqmap.status().settings.stiffness === 800);
  await page.selectOption('#layer', 'exact');
  await until(page, () => window.sqmap.status().settings.layer === 'exact');
  assert.match(await page.textContent('#device-facts'), /467 N\/m/);
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
  await until(page, () => { const f = window.sqmap.frame(); return f.engaged && f.contacts > 0; });
  await page.mouse.up();
});

test('parts are split, taken back, joined and baked', async () => {
  await page.click('#tab-look');
  await settled(page);
  const [x, y] = await onSurface(page, 1);
  await page.mouse.click(x, y);
  const count = () => page.evaluate(() => window.sqmap.facts()[1].parts.length);
  const before = await count();
  await page.click('#split');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  await page.click('#undo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n && !window.sqmap.facts()[1].edited, before);
  await page.click('#redo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  await page.click('#merge');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before);
  await page.click('#undo');
  await until(page, (n) => window.sqmap.facts()[1].parts.length === n, before + 1);
  await page.click('#bake');
  await until(page, (n) => !window.sqmap.facts()[1].edited && window.sqmap.facts()[1].parts.length === n, before + 1);
  const baked = await page.evaluate(() => window.sqmap.facts()[1]);
  assert.ok(baked.parts.every((p) => p.certified));
});

const drop = (name, text) => page.evaluate(([n, t]) => {
  const data = new DataTransfer();
  data.items.add(new File([t], n));
  window.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
}, [name, text]);

test('a bad mesh is refused with its reason and its cure', async () => {
  await drop('open.off', 'OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n');
  await page.waitForSelector('#verdict.bad');
  assert.match(await page.textContent('#verdict'), /REFUSED E_OPEN.*What helps/s);
  await page.screenshot({ path: path.join(folder, 'refused.png') });
  assert.equal(await page.evaluate(() => window.sqmap.facts().length), 2);
});

test('a good mesh is baked, with progress, and stands beside the others', async () => {
  const file = path.join(folder, 'box.obj');
  execFileSync(sqmap, ['shapes', 'rounded_box', '-o', file]);
  await drop('box.obj', fs.readFileSync(file, 'utf8'));
  await page.waitForSelector('#verdict.good');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.ready());
  const f = await page.evaluate(() => window.sqmap.facts()[2]);
  assert.equal(f.name, 'box');
  assert.ok(f.parts.length > 0 && f.parts.every((p) => p.certified));
});

test('a small hole is filled when asked', async () => {
  const lines = fs.readFileSync(path.join(folder, 'box.obj'), 'utf8').trim().split('\n');
  await drop('holed.obj', lines.slice(0, -1).join('\n') + '\n');  // a face short
  await page.waitForSelector('#verdict.bad #holes');
  await page.click('#holes');
  await page.waitForSelector('#verdict.good');
  assert.match(await page.textContent('#verdict'), /REPAIRED.*filled_holes/s);
  await until(page, () => window.sqmap.facts().length === 4);
  const last = await page.$$('#facts .object');
  await last[3].click();
  await page.click('#remove');
  await until(page, () => window.sqmap.facts().length === 3 && window.sqmap.world.ready());
});

test('models are saved as GLB, JSON and .sqmap', async () => {
  for (const [kind, check] of [['glb', (b) => b.subarray(0, 4).toString() === 'glTF'], ['json', (b) => JSON.parse(b).parts.length > 0], ['sqmap', (b) => b.length > 1000]]) {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(`#save-${kind}`)]);
    const to = path.join(folder, `saved.${kind}`);
    await download.saveAs(to);
    assert.ok(check(fs.readFileSync(to)), kind);
  }
  execFileSync(sqmap, ['info', path.join(folder, 'saved.sqmap')]);
});

test('a link restores the view', async () => {
  await page.check('#superquadrics');
  await page.click('#link');
  const pose = await page.evaluate(() => window.sqmap.world.pose());
  const link = page.url();
  const other = await open();
  await other.goto('about:blank');
  await other.goto(link);
  await other.waitForSelector('body[data-ready]');
  const restored = await other.evaluate(() => window.sqmap.world.pose());
  restored.forEach((c, i) => assert.ok(Math.abs(c - pose[i]) < 2e-3));
  assert.ok(await other.isChecked('#superquadrics'));
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
  await page.keyboard.press('ArrowLeft');  // round to the last tab
  await tab('#begin');
  await page.keyboard.press('Enter');
  await until(page, () => window.sqmap.game.running);
  const rounds = await page.evaluate(() => window.sqmap.facts().length);
  for (let round = 0; round < rounds; ++round) {
    const target = await page.evaluate(() => window.sqmap.game.target);
    if (round === 0) {
      await tab('#stage');
      await page.keyboard.press('Enter');
      for (let i = 0; i < 24; ++i) await page.keyboard.press(['ArrowLeft', 'ArrowUp', 'ArrowRight', 'ArrowDown'][i % 4]);
      // A torus has nothing in its middle: look for it beside.
      for (let i = 0; i < 40 && !(await page.evaluate(() => window.sqmap.frame()?.contacts > 0)); ++i) { await page.keyboard.press('ArrowRight'); await page.waitForTimeout(60); }
      await until(page, () => window.sqmap.frame()?.contacts > 0);
      await page.screenshot({ path: path.join(folder, 'recognise.png') });
      // The hidden object is nowhere told.
      const name = await page.evaluate((t) => window.sqmap.facts()[t].name, target);
      assert.ok(!(await page.textContent('#force')).includes(name) && await page.isHidden('#facts'));
      await page.keyboard.press('Enter');
    }
    await tab('input[name=guess]');
    // Right in all rounds but the last.
    const wanted = round < rounds - 1 ? target : (target + 1) % rounds;
    await page.keyboard.press('Space');
    for (let i = 0; i < rounds && !(await page.isChecked(`input[name=guess][value="${wanted}"]`)); ++i) await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    await until(page, (n) => document.querySelector('#score') || document.querySelector('legend')?.textContent.startsWith(`Round ${n}`), round + 2);
  }
  assert.match(await page.textContent('#score'), new RegExp(`^${rounds - 1} of ${rounds} right`));
  const rows = (await page.evaluate(() => window.sqmap.game.results())).trim().split('\n');
  assert.equal(rows.length, rounds + 1);
  assert.match(rows[0], /^participant,date,round,object,hash,guess,right,seconds/);
  assert.ok(Number(rows[1].split(',')[8]) > 0, 'time in touch is recorded');
});

test('nothing overflows, light and dark, narrow and wide', async () => {
  for (const [name, width, height, colorScheme] of [['wide-light', 1360, 820, 'light'], ['wide-dark', 1360, 820, 'dark'], ['narrow-light', 390, 844, 'light'], ['narrow-dark', 390, 844, 'dark']]) {
    const other = await open({ viewport: { width, height }, colorScheme });
    for (const mode of ['look', 'touch', 'recognise']) {
      await other.click(`#tab-${mode}`);
      await other.waitForTimeout(250);
      assert.ok(await other.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name} ${mode}`);
      const box = await (await other.$('#stop')).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= width && box.width * box.height > 2000, 'STOP is in sight');
      await other.screenshot({ path: path.join(folder, `${name}-${mode}.png`) });
    }
    await other.close();
  }
});

let failed = 0;
for (const [name, body] of tests) {
  try {
    await body();
    console.log(`ok    ${name}`);
  } catch (e) {
    ++failed;
    console.log(`FAIL  ${name}\n${e.stack}`);
    if (page) await page.screenshot({ path: path.join(folder, `failed-${failed}.png`) }).catch(() => {});
  }
}
if (complaints.length) { ++failed; console.log(`FAIL  the page complains:\n${complaints.join('\n')}`); }
await browser.close();
program.kill();
process.exit(failed ? 1 : 0);
