// Tests that everyone can use the page: axe in every tab, light, dark, high contrast and narrow, with all that is folded open.
// usage: node access_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { openPage, require, run, start, test, unfold, until } from './harness.mjs';

const axe = fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
const { url } = await start();
let page;
const clean = async (where) => {
  const found = await page.evaluate(async () => (await window.axe.run(document, { resultTypes: ['violations'] })).violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')}`));
  assert.deepEqual(found, [], where);
};

for (const [name, options, theme] of [
  ['light', {}], ['dark', { colorScheme: 'dark' }], ['high contrast', {}, 'contrast'], ['narrow', { viewport: { width: 390, height: 844 } }], ['narrow, dark', { viewport: { width: 390, height: 844 }, colorScheme: 'dark' }]])
  test(`axe finds nothing: ${name}`, async () => {
    await page?.close();
    page = await openPage(url, { viewport: { width: 1360, height: 800 }, bypassCSP: true, ...options });
    for (let i = 0; theme && i < 3 && (await page.evaluate(() => document.documentElement.dataset.theme)) !== theme; ++i) await page.click('#theme');
    if (await page.isVisible('#sheet')) await page.click('#sheet');
    await page.evaluate(axe);
    for (const tab of ['touch', 'look', 'recognise', 'dress']) {
      if (await page.isHidden(`#tab-${tab}`)) continue;
      await page.click(`#tab-${tab}`);
      await unfold(page);
      await clean(tab);
    }
    // Parts that are open for a while only: choices of files, exports, the keys, a running game, a question.
    await page.click('#tab-look');
    await page.click('#reading');
    await clean('the choices of files');
    await page.click('#close-verdict');
    await page.evaluate(() => { document.querySelector('#export').open = true; });
    await clean('the exports');
    await page.evaluate(() => { document.querySelector('#export').open = false; });
    await page.selectOption('#colour', 'error');
    await until(page, () => !document.querySelector('#worst').hidden);
    const sheet = await page.isVisible('#sheet');
    if (sheet) await page.click('#sheet');  // it lies over the legend
    await page.click('#worst');
    await clean('the worst error');
    if (sheet) await page.click('#sheet');
    await page.selectOption('#colour', 'parts');
    await page.keyboard.press('F1');
    await page.waitForSelector('#keys[open]');
    await clean('the keys');
    await page.keyboard.press('Escape');
    await page.click('#tab-recognise');
    await page.click('#begin');
    await clean('a game');
  });

await run(() => page);
