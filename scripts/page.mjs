// Runs the page of `sqmap view` in Chromium with software rendering, for pictures or for figures.
// usage: node scripts/page.mjs pictures SQMAP CHROMIUM [MESH]     needs npm's packages (./dev view installs them)
//   docs/images/view_map.png, a hand baked both ways and a point looked at; docs/images/recognise.png, a hidden object that is touched;
//   with a mesh, the demo's triceratops, also docs/images/view.png, where its back is touched.
// usage: node scripts/page.mjs figures SQMAP CHROMIUM MODEL...
//   prints what the page costs: first paint, time until it can be touched, bytes, draw calls, frames, and the CPU time of a frame in each
//   process, which another program on the machine changes less than the frames a second.
//   MINUTES=n in the environment: touches on for so long, over the whole stage, and tells the memory of each process every minute;
//   then how much it grew from the minutes 5 to 15 to the last ten. WINDOW=WxH: of that; CSV=FILE: keeps the numbers.
//   COMPOSITING=gl: the whole page through SwiftShader, as the tests have it; else as a browser does without a card.
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const [, , what, sqmap, chromium, ...files] = process.argv;
const root = path.join(path.dirname(fileURLToPath(import.meta.url)), '..');
const { chromium: browserType } = createRequire(path.join(root, 'apps/viewer/web/'))('playwright-core');
const gl = what === 'pictures' || process.env.COMPOSITING === 'gl' ? ['--use-gl=angle', '--use-angle=swiftshader'] : [];

/// The program with files, and the address of its page.
async function serve(...shown) {
  const program = spawn(sqmap, ['view', ...shown], { stdio: ['ignore', 'pipe', 'inherit'] });
  const url = await new Promise((resolve) => { let text = ''; program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); }); });
  return { program, url };
}

/// A picture of the page of these files, after act.
async function picture(browser, shown, name, [width, height], act) {
  const { program, url } = await serve(...shown);
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: 'light' });
  await page.goto(url);
  await page.waitForSelector('body[data-ready]');
  await page.waitForTimeout(500);
  await act(page);
  await page.screenshot({ path: path.join(root, 'docs/images', name) });
  await page.close();
  program.kill();
}

async function pictures(browser) {
  const [animal] = files, folder = fs.mkdtempSync(path.join(os.tmpdir(), 'sqmap-'));
  const models = ['normal', 'central'].map((projection) => {
    const model = path.join(folder, `hand, ${projection} maps.sqmap`);
    if (projection === 'normal') execFileSync(sqmap, ['shapes', 'hand', '-o', path.join(folder, 'hand.obj')]);
    execFileSync(sqmap, ['bake', path.join(folder, 'hand.obj'), '-o', model, '--projection', projection, '--exact'], { stdio: 'ignore' });
    return model;
  });
  await picture(browser, models, 'view_map.png', [1240, 1500], async (page) => {
    await page.click('#tab-look');
    await page.focus('#stage');
    await page.keyboard.press('Home');
    await page.waitForTimeout(500);
    // The lower palm of the first hand.
    const at = await page.evaluate(() => {
      const s = window.sqmap, f = s.facts()[0], b = document.querySelector('#stage').getBoundingClientRect();
      const q = s.world.project(s.world.controls.target.clone().set(...f.position));
      return [b.left + ((q.x + 1) / 2) * b.width, b.top + ((1.12 - q.y) / 2) * b.height];
    });
    await page.mouse.click(...at);
    await page.selectOption('#surface', 'clear');
    await page.selectOption('#projector', 'pyramid');
    await page.locator('#s-below').fill('4');
    await page.waitForFunction(() => document.querySelectorAll('#answers tbody tr').length === 7 && window.sqmap.map.over().steps.length > 20 && window.sqmap.world.traces.count().section > 1);
    await page.evaluate(() => { document.querySelector('#s-below').closest('.card').scrollIntoView({ block: 'start' }); });
    await page.waitForTimeout(1500);
  });

  const hidden = ['hand', 'rounded_box', 'bent'].map((shape) => path.join(folder, `${shape.replace('_', ' ')}.obj`));
  for (const file of hidden) execFileSync(sqmap, ['shapes', path.basename(file, '.obj').replace(' ', '_'), '-o', file]);
  await picture(browser, hidden, 'recognise.png', [1240, 760], async (page) => {
    await page.click('#tab-recognise');
    await page.click('#begin');
    await page.waitForFunction(() => window.sqmap.game.running);
    await page.focus('#stage');
    await page.keyboard.press('Enter');
    for (let i = 0; i < 90 && !(await page.evaluate(() => window.sqmap.frame()?.contacts > 0)); ++i) { await page.keyboard.press('ArrowRight'); await page.waitForTimeout(60); }
    await page.waitForFunction(() => Math.hypot(...window.sqmap.frame().force) > 0.3);
    await page.waitForTimeout(1500);
  });

  if (animal)
    await picture(browser, [animal], 'view.png', [1360, 1160], async (page) => {
      await page.click('#tab-touch');
      await page.waitForTimeout(800);
      // The highest point of the back that is seen.
      const at = await page.evaluate(() => {
        const s = window.sqmap, b = document.querySelector('#stage').getBoundingClientRect();
        for (let y = 0.9; y > -0.5; y -= 0.02) { const h = s.world.cast(-0.05, y); if (h && h.normal.y > 0.5) return [b.left + 0.475 * b.width, b.top + ((1 - y) / 2) * b.height + 12]; }
        return null;
      });
      await page.mouse.move(...at);
      for (let tries = 0; tries < 8; ++tries) {
        await page.mouse.down();
        await page.waitForTimeout(1500);
        if (await page.evaluate(() => Math.hypot(...window.sqmap.frame().force) > 0.3)) break;
        await page.mouse.up();
        await page.waitForTimeout(400);
      }
      for (let k = 0; k < 24; ++k) { await page.mouse.move(at[0] + 60 * Math.sin(k / 4), at[1] + 4 * Math.cos(k / 3)); await page.waitForTimeout(130); }
      // A busy machine may have lost the force meanwhile; and the picture is fine once the tool rests.
      await page.waitForFunction(() => Math.hypot(...window.sqmap.frame().force) > 0.3);
      await page.waitForTimeout(900);
    });
  fs.rmSync(folder, { recursive: true });
}

async function figures(browser) {
  const { program, url } = await serve(...files);
  const bytes = (await Promise.all(['', 'app.js', 'app.css'].map(async (name) => gzipSync(Buffer.from(await (await fetch(new URL(name + url.slice(url.indexOf('?')), url))).arrayBuffer()), { level: 9 }).length))).reduce((a, b) => a + b, 0);
  const paints = [], ready = [], messages = [];
  let page;
  for (let i = 0; i < 3; ++i) {
    await page?.close();
    page = await browser.newPage({ viewport: { width: 1360, height: 800 } });
    page.on('console', (m) => messages.push(m.text()));
    page.on('pageerror', (e) => messages.push(e.message));
    await page.addInitScript(() => {
      new MutationObserver(() => { if (document.body?.dataset.ready !== undefined && !window.readyAt) window.readyAt = performance.now(); }).observe(document, { subtree: true, attributes: true, childList: true });
    });
    await page.goto(url);
    await page.waitForSelector('body[data-ready]');
    await page.waitForTimeout(300);
    paints.push(await page.evaluate(() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN));
    ready.push(await page.evaluate(() => window.readyAt));
  }
  // Touching, dragged to and fro for eight seconds; the first four bring the quality down to the machine.
  const at = await page.evaluate(() => { const s = window.sqmap, b = document.querySelector('#stage').getBoundingClientRect(); for (let r = 0; r < 0.6; r += 0.02) for (let a = 0; a < 6.28; a += 0.4) { const x = r * Math.cos(a), y = r * Math.sin(a); if (s.world.cast(x, y)) return [b.left + ((x + 1) / 2) * b.width, b.top + ((1 - y) / 2) * b.height]; } return null; });
  await page.mouse.move(...at);
  await page.mouse.down();
  /// A figure of each of this process's children, by their kind.
  function sums(of) {
    const rows = fs.readdirSync('/proc').filter((d) => /^\d+$/.test(d)).flatMap((d) => {
      try { const s = fs.readFileSync(`/proc/${d}/stat`, 'utf8'), r = s.slice(s.lastIndexOf(')') + 2).split(' '); return [{ pid: Number(d), parent: Number(r[1]), own: of(r), words: fs.readFileSync(`/proc/${d}/cmdline`, 'utf8') }]; } catch { return []; }
    });
    const out = {}, add = (parent) => { for (const r of rows.filter((x) => x.parent === parent)) { const kind = r.pid === program.pid ? 'program' : /--type=([a-z]+)/.exec(r.words)?.[1] ?? 'browser'; out[kind] = (out[kind] ?? 0) + r.own; add(r.pid); } };
    add(process.pid);
    return out;
  }
  const cpu = () => sums((r) => 10 * (Number(r[11]) + Number(r[12])));    // ms
  const memory = () => sums((r) => 4096 * Number(r[21]) / 1e6);         // MB
  let cost, before, frames;
  for (let i = 0; i < 80; ++i) {
    if (i === 40) [before, frames] = [cpu(), await page.evaluate(() => window.sqmap.meter.frames)];
    await page.mouse.move(at[0] + 12 * Math.sin(i / 5), at[1] + 8 * Math.cos(i / 5));
    await page.waitForTimeout(100);
  }
  cost = await page.evaluate(() => window.sqmap.meter.cost());
  const after = cpu(), passed = cost.frames - frames;
  await page.mouse.up();
  const middle = (x) => x.sort((a, b) => a - b)[1];
  console.log(`first paint ${middle(paints).toFixed(0)} ms, can be touched after ${middle(ready).toFixed(0)} ms, page ${(bytes / 1000).toFixed(0)} kB gzipped`);
  console.log(`touching: ${(1000 / cost.frameMs).toFixed(1)} frames/s, scripts ${cost.scriptMs.toFixed(2)} ms a frame, ${cost.calls} draw calls, ${cost.triangles.toLocaleString('en')} triangles`);
  console.log(`CPU ms a frame: ${['gpu', 'renderer', 'browser', 'program'].map((k) => `${k} ${(((after[k] ?? 0) - (before[k] ?? 0)) / passed).toFixed(1)}`).join(', ')}`);
  if (process.env.MINUTES) {
    const [width, height] = (process.env.WINDOW ?? '1360x800').split('x').map(Number), kinds = ['program', 'renderer', 'gpu', 'browser'], rows = [];
    await page.setViewportSize({ width, height });
    await page.evaluate(() => window.sqmap.world.frame(window.sqmap.world.objects.focus));
    await page.waitForTimeout(500);
    const devtools = await page.context().newCDPSession(page), b = await (await page.$('#stage')).boundingBox(), until = Date.now() + 60000 * Number(process.env.MINUTES);
    const keep = (line) => { if (process.env.CSV) fs.appendFileSync(process.env.CSV, `${line}\n`); };
    keep(`time,heap_MB,${kinds.map((k) => `${k}_MB`).join(',')},touches,felt,messages`);
    let touches = 0, felt = 0;
    for (let next = 0; Date.now() < until; ++touches) {
      if (Date.now() >= next) {
        next = Date.now() + 60000;
        await devtools.send('HeapProfiler.collectGarbage');
        const heap = (await devtools.send('Runtime.getHeapUsage')).usedSize / 1e6, all = memory(), sizes = kinds.map((kind) => all[kind] ?? 0);
        rows.push([heap, ...sizes]);
        console.log(`${new Date().toISOString().slice(11, 19)} heap ${heap.toFixed(2)} MB; resident ${kinds.map((kind, i) => `${kind} ${sizes[i].toFixed(0)}`).join(', ')} MB; ${felt} of ${touches} touches felt; ${messages.length} messages`);
        keep([new Date().toISOString().slice(11, 19), heap.toFixed(3), ...sizes.map((x) => x.toFixed(1)), touches, felt, messages.length].join(','));
      }
      // A touch of two seconds, each elsewhere about the middle of the object.
      const x = b.x + b.width * (0.5 + 0.1 * Math.sin(2.4 * touches)), y = b.y + b.height * (0.5 + 0.1 * Math.cos(1.7 * touches));
      await page.mouse.move(x, y);
      await page.mouse.down();
      for (let i = 0; i < 20; ++i) { await page.mouse.move(x + 12 * Math.sin(i / 4), y + 8 * Math.cos(i / 3)); await page.waitForTimeout(100); }
      if (await page.evaluate(() => Math.hypot(...(window.sqmap.frame()?.force ?? [0])) > 0)) ++felt;
      await page.mouse.up();
    }
    const mean = (from, to, k) => { const part = rows.slice(from, to); return part.reduce((sum, r) => sum + r[k], 0) / part.length; };
    if (rows.length >= 25) console.log(`growth from minutes 5 to 15 to the last ten: ${['heap', ...kinds].map((kind, k) => `${kind} ${(100 * (mean(-10, undefined, k) / mean(5, 15, k) - 1)).toFixed(1)} %`).join(', ')}`);
    for (const text of messages) console.log(text);
  }
  program.kill();
}

const run = { pictures, figures }[what];
if (!run || !chromium) {
  console.error('usage: node scripts/page.mjs pictures|figures SQMAP CHROMIUM FILE...');
  process.exit(64);
}
const browser = await browserType.launch({ executablePath: chromium, args: ['--no-sandbox', '--enable-unsafe-swiftshader', ...gl] });
await run(browser);
await browser.close();
process.exit(0);
