// Makes docs/images/view_map.png: the page of `sqmap view` with a hand baked both ways and a point looked at.
// usage: node scripts/view_images.mjs SQMAP CHROMIUM     needs npm's packages (./dev view installs them)
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [, , sqmap, chromium] = process.argv;
const root = path.join(path.dirname(fileURLToPath(import.meta.url)), '..');
const { chromium: browserType } = createRequire(path.join(root, 'apps/viewer/web/'))('playwright-core');
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'sqmap-'));
const models = ['normal', 'central'].map((projection) => {
  const model = path.join(folder, `hand, ${projection} maps.sqmap`);
  if (projection === 'normal') execFileSync(sqmap, ['shapes', 'hand', '-o', path.join(folder, 'hand.obj')]);
  execFileSync(sqmap, ['bake', path.join(folder, 'hand.obj'), '-o', model, '--projection', projection, '--exact'], { stdio: 'ignore' });
  return model;
});
const program = spawn(sqmap, ['view', ...models], { stdio: ['ignore', 'pipe', 'inherit'] });
const url = await new Promise((resolve) => { let text = ''; program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); }); });
const browser = await browserType.launch({ executablePath: chromium, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 1240, height: 1500 }, colorScheme: 'light' });
await page.goto(url);
await page.waitForSelector('body[data-ready]');
// The middle of the first hand's palm.
await page.waitForTimeout(500);
const at = await page.evaluate(() => {
  const s = window.sqmap, f = s.facts()[0], b = document.querySelector('#stage').getBoundingClientRect();
  const q = s.world.project(s.world.controls.target.clone().set(...f.place));
  return [b.left + ((q.x + 1) / 2) * b.width, b.top + ((1.12 - q.y) / 2) * b.height];
});
await page.mouse.click(...at);
await page.selectOption('#surface', 'clear');
await page.selectOption('#projector', 'pyramid');
await page.locator('#s-below').fill('4');
await page.waitForFunction(() => document.querySelectorAll('#answers tbody tr').length === 7 && window.sqmap.map.over().steps.length > 20 && window.sqmap.world.traces.count().section > 1);
await page.evaluate(() => { document.querySelector('#panel').scrollTop = 0; });
await page.waitForTimeout(1500);
await page.screenshot({ path: path.join(root, 'docs/images/view_map.png') });
await browser.close();
program.kill();
fs.rmSync(folder, { recursive: true });
