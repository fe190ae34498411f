// Contacts between objects, as the page shows them: none while they are apart, and by kind and region once one is in the other.
// usage: node meetings_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import path from 'node:path';
import { folder, openPage, run, settled, start, test, until } from './harness.mjs';

const { url } = await start();
const page = await openPage(url, { viewport: { width: 1360, height: 900 } }, { mode: 'look' });
const facts = () => page.evaluate(() => window.sqmap.facts());
const shown = () => page.evaluate(() => window.sqmap.shownMeetings());
const shot = (name) => page.screenshot({ path: path.join(folder, `${name}.png`) });

test('apart, objects have no contacts, and the page says so', async () => {
  await settled(page);
  await page.check('#show-meetings');
  await until(page, () => /No two objects touch/.test(document.querySelector('#meetings').textContent));
  assert.deepEqual(await shown(), { pairs: [], open: [], drawn: 0 });
});

test('one in the other, each contact is listed by region and kind, and drawn between both', async () => {
  const [first, second] = await facts();
  await page.click(`#move-${second.id}`);
  await page.waitForSelector('#move-x');
  for (const [axis, to] of [['x', first.position[0] + 0.7 * second.half[0]], ['y', first.position[1]], ['z', first.position[2]]]) {
    await page.fill(`#move-${axis}`, String(Math.round(1000 * to)));
    await page.press(`#move-${axis}`, 'Enter');
    await until(page, ([k, x]) => Math.abs(window.sqmap.facts()[1].position[k] - x) < 6e-4, ['xyz'.indexOf(axis), to]);
  }
  await until(page, () => window.sqmap.shownMeetings().pairs.length === 1);
  await page.waitForTimeout(1000);  // for the last of the three moves
  await until(page, () => window.sqmap.shownMeetings().pairs.length === 1);
  const { pairs: [{ a, b, found, contacts }], drawn } = await shown(), [one, other] = await facts();
  assert.equal(contacts.length, found, 'none is left out');
  assert.ok(contacts.some((c) => c[0] === 0) && contacts.some((c) => c[0] !== 0), 'not vertices alone');
  assert.deepEqual([a, b], [0, 1]);
  for (const c of contacts)
    for (const [at, f] of [[2, one], [2, other], [5, one], [5, other]])
      for (let k = 0; k < 3; ++k) assert.ok(Math.abs(c[at + k] - f.position[k]) < f.half[k] + c[8] + 1e-6, `${c} is not where both are`);
  const kinds = [0, 1, 2].map((kind) => contacts.filter((c) => c[0] === kind).length);
  assert.equal(drawn, 1 + kinds.filter((n) => n > 0).length, 'lines, and a set of marks for each kind');
  const rows = await page.$$eval('#meetings tbody tr', (all) => all.map((r) => [...r.querySelectorAll('td')].map((d) => Number(d.textContent))));
  assert.equal(rows.length, new Set(contacts.map((c) => c[1])).size);
  assert.deepEqual([0, 1, 2].map((kind) => rows.reduce((sum, row) => sum + row[kind], 0)), kinds);
  assert.ok(Math.abs(Math.max(...rows.map((row) => row[3])) - 1000 * Math.max(...contacts.map((c) => c[8]))) < 1e-3);
  assert.match(await page.textContent('#meetings caption'), new RegExp(`^${one.name} and ${other.name}: ${rows.length} region`));
  await page.locator('#meetings').scrollIntoViewIfNeeded();
  await shot('contacts');
});

test('a region stands out while it is pointed at or has the focus', async () => {
  const { pairs: [{ contacts }], drawn } = await shown(), rows = await page.$$('#meetings tbody tr');
  await rows[0].focus();
  const own = await shown();
  if (rows.length > 1) assert.ok(own.drawn > drawn, 'the others are drawn pale');
  else assert.equal(own.drawn, drawn);
  assert.equal(own.pairs[0].contacts.length, contacts.length);
  await shot('region');
});

test('off, nothing is drawn', async () => {
  await page.uncheck('#show-meetings');
  await until(page, () => window.sqmap.shownMeetings().drawn === 0 && !document.querySelector('#meetings').textContent);
});

await run(() => page);
