// A program, a browser and pages for the tests of the page; tests in order, and what they have in common.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

export const [, , sqmap, chromium, folder] = process.argv;
const web = path.join(path.dirname(fileURLToPath(import.meta.url)), '../../apps/viewer/web/');
export const require = createRequire(web);
const { chromium: browserType } = require('playwright-core');
fs.rmSync(folder, { recursive: true, force: true });
fs.mkdirSync(folder, { recursive: true });

/// Starts the program; its address.
export async function start(...options) {
  const program = spawn(sqmap, ['view', ...options], { stdio: ['ignore', 'pipe', 'inherit'] });
  process.on('exit', () => program.kill());
  const url = await new Promise((resolve, reject) => {
    let text = '';
    program.stdout.on('data', (d) => { text += d; const m = /http:\S+/.exec(text); if (m) resolve(m[0]); });
    program.on('exit', (code) => reject(new Error(`sqmap view ended with ${code}`)));
  });
  return { program, url };
}

// Software rendering: the machine that tests has no graphics card.
export const GL = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
export const launch = (args = GL, headless = true) => browserType.launch({ executablePath: chromium, headless, args });
export const browser = await launch();
export const complaints = [];
/// A page of an address, once it is ready. mode: the tab that is then chosen; empty: what the page begins with.
export async function openPage(url, options = {}, { mode = '', from = browser } = {}) {
  const page = await from.newPage({ viewport: { width: 1100, height: 720 }, colorScheme: 'light', acceptDownloads: true, ...options });
  page.setDefaultTimeout(60000);
  page.on('pageerror', (e) => complaints.push(e.message));
  page.on('console', (m) => { if (m.type() === 'error' && !/ERR_|WebSocket|Failed to load resource|WebGL/.test(m.text())) complaints.push(m.text()); });
  await page.goto(url);
  await page.waitForSelector('body[data-ready]');
  if (mode) await page.click(`#tab-${mode}`);
  return page;
}

export const until = async (page, what, arg, timeout = Number(process.env.PATIENCE ?? 120000)) => page.waitForFunction(what, arg, { timeout, polling: 50 });
/// Waits for the figure. The thread that bakes its bones gives way to all others, so that a busy machine takes minutes.
export const dressed = (page) => until(page, () => window.sqmap.costume.frames > 20, undefined, 600000);
/// Once the stage has the size that its mode gives it.
export const settled = async (page) => {
  await until(page, () => {
    const c = document.querySelector('#stage'), b = c.parentElement.getBoundingClientRect();
    const finest = window.sqmap.world.finest();
    return Math.abs(c.width / finest - b.width) < 2 && Math.abs(c.height / finest - b.height) < 2;
  });
  await page.waitForTimeout(100);
};
/// A position of the screen where an object's surface faces the eye, well within a part.
export const onSurface = (page, object) => page.evaluate((i) => {
  const s = window.sqmap, f = s.facts()[i], b = document.querySelector('#stage').getBoundingClientRect();
  const q = s.world.project(s.world.controls.target.clone().set(...f.position));
  for (let r = 0; r < 0.6; r += 0.02)
    for (let a = 0; a < 6.28; a += 0.5) {
      const x = q.x + r * Math.cos(a), y = q.y + r * Math.sin(a), hit = s.world.cast(x, y);
      if (hit?.object === i && [[1, 0], [-1, 0], [0, 1], [0, -1]].every(([u, v]) => s.world.cast(x + 0.02 * u, y + 0.02 * v)?.part === hit.part)) return [b.left + ((x + 1) / 2) * b.width, b.top + ((1 - y) / 2) * b.height];
    }
  return null;
}, object);
/// Touches an object until there is a force; the button stays down. A machine that was too busy for the servo may end the force:
/// then it is lifted and touched again, as the page says.
export const feel = async (page, object, least) => {
  const [x, y] = await onSurface(page, object);
  await page.mouse.move(x, y);
  for (let tries = 0; ; ++tries) {
    await page.mouse.down();
    const felt = await until(page, ([i, n]) => {
      const f = window.sqmap.frame();
      return f && (f.faults || (f.contacts > 0 && !f.engaged) ? 'lift' : f.engaged && f.object === i && Math.hypot(...f.force) > n && 'force');
    }, [object, least]);
    if ((await felt.jsonValue()) === 'force') return [x, y];
    assert.ok(tries < 8, 'the servo keeps finding faults');
    await page.mouse.up();
    await page.waitForTimeout(300);
  }
};
/// Opens all that is folded in the panel.
export const unfold = (page) => page.evaluate(() => document.querySelectorAll('#panel details.folded').forEach((d) => { d.open = true; }));
export const drop = (page, ...files) => page.evaluate((all) => {
  const data = new DataTransfer();
  for (const [name, text] of all) data.items.add(new File([text], name));
  window.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
}, files);

/// ONLY=words in the environment: those whose name has them, and what they need is their own matter.
const tests = [], only = process.env.ONLY ?? '';
export const test = (name, body) => { if (name.includes(only)) tests.push([name, body]); };
/// One after the other, then the end. shown: the page whose picture a failure leaves behind.
export async function run(shown = () => null) {
  let failed = 0;
  for (const [name, body] of tests) {
    try {
      await body();
      console.log(`ok    ${name}`);
    } catch (e) {
      ++failed;
      console.log(`FAIL  ${name}\n${e.stack}`);
      await shown()?.screenshot({ path: path.join(folder, `failed-${failed}.png`) }).catch(() => {});
    }
  }
  if (complaints.length) { ++failed; console.log(`FAIL  the page complains:\n${complaints.join('\n')}`); }
  await browser.close();
  process.exit(failed ? 1 : 0);
}
