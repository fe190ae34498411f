#!/usr/bin/env node
// What the page costs in Chromium with software rendering: first paint, time until it can be touched, bytes, draw calls, frames.
// usage: node scripts/page_figures.mjs SQMAP CHROMIUM MODEL...
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const [, , sqmap, chromium, ...models] = process.argv;
const { chromium: browserType } = createRequire(path.join(path.dirname(fileURLToPath(import.meta.url)), '../apps/viewer/web/'))('playwright-core');
const program = spawn(sqmap, ['view', ...models], { stdio: ['ignore', 'pipe', 'inherit'] });
const url = await new Promise((resolve) => { let text = ''; program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); }); });
const browser = await browserType.launch({ executablePath: chromium, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });

const bytes = (await Promise.all(['', 'app.js', 'app.css'].map(async (name) => gzipSync(Buffer.from(await (await fetch(new URL(name + url.slice(url.indexOf('?')), url))).arrayBuffer()), { level: 9 }).length))).reduce((a, b) => a + b, 0);
const paints = [], ready = [];
let page;
for (let i = 0; i < 3; ++i) {
  await page?.close();
  page = await browser.newPage({ viewport: { width: 1360, height: 800 } });
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
let cost;
for (let i = 0; i < 80; ++i) {
  await page.mouse.move(at[0] + 12 * Math.sin(i / 5), at[1] + 8 * Math.cos(i / 5));
  await page.waitForTimeout(100);
}
cost = await page.evaluate(() => window.sqmap.meter.cost());
await page.mouse.up();
const middle = (x) => x.sort((a, b) => a - b)[1];
console.log(`first paint ${middle(paints).toFixed(0)} ms, can be touched after ${middle(ready).toFixed(0)} ms, page ${(bytes / 1000).toFixed(0)} kB gzipped`);
console.log(`touching: ${(1000 / cost.frameMs).toFixed(1)} frames/s, scripts ${cost.scriptMs.toFixed(2)} ms a frame, ${cost.calls} draw calls, ${cost.triangles.toLocaleString('en')} triangles`);
await browser.close();
program.kill();
process.exit(0);
