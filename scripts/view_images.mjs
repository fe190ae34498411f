// Makes pictures of the page of `sqmap view`: docs/images/view_map.png, a hand baked both ways and a point looked at; with a mesh,
// the demo's triceratops, also docs/images/view.png, where its back is touched.
// usage: node scripts/view_images.mjs SQMAP CHROMIUM [MESH]     needs npm's packages (./dev view installs them)
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [, , sqmap, chromium, animal] = process.argv;
const root = path.join(path.dirname(fileURLToPath(import.meta.url)), '..');
const { chromium: browserType } = createRequire(path.join(root, 'apps/viewer/web/'))('playwright-core');
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'sqmap-'));
const models = ['normal', 'central'].map((projection) => {
  const model = path.join(folder, `hand, ${projection} maps.sqmap`);
  if (projection === 'normal') execFileSync(sqmap, ['shapes', 'hand', '-o', path.join(folder, 'hand.obj')]);
  execFileSync(sqmap, ['bake', path.join(folder, 'hand.obj'), '-o', model, '--projection', projection, '--exact'], { stdio: 'ignore' });
  return model;
});
const browser = await browserType.launch({ executablePath: chromium, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });

/// What act does on the page of these files, then a picture.
async function picture(files, name, [width, height], act) {
  const program = spawn(sqmap, ['view', ...files], { stdio: ['ignore', 'pipe', 'inherit'] });
  const url = await new Promise((resolve) => { let text = ''; program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); }); });
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: 'light' });
  await page.goto(url);
  await page.waitForSelector('body[data-ready]');
  await page.waitForTimeout(500);
  await act(page);
  await page.screenshot({ path: path.join(root, 'docs/images', name) });
  await page.close();
  program.kill();
}

await picture(models, 'view_map.png', [1240, 1500], async (page) => {
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

if (animal)
  await picture([animal], 'view.png', [1360, 1000], async (page) => {
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
await browser.close();
fs.rmSync(folder, { recursive: true });
