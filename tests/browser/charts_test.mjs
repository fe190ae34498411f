// Tests what a researcher keeps: force against depth by one button as a table and a drawing, spans of contacts, recordings that the
// program computes again.
// usage: node charts_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { feel, folder, openPage, run, settled, sqmap, start, test, until } from './harness.mjs';

const { url } = await start();
let page = await openPage(url, { viewport: { width: 1100, height: 480 } });  // small: it is drawn in software
const download = async (id) => {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(id)]);
  const to = path.join(folder, file.suggestedFilename());
  await file.saveAs(to);
  return [file.suggestedFilename(), fs.readFileSync(to, 'utf8')];
};
const sweep = async (depths = 20) => {
  const before = await page.evaluate(() => window.sqmap.sweep.kept.length);
  for (let tries = 0; ; ++tries) {
    await page.click('#sweep');
    await until(page, (n) => window.sqmap.sweep.kept.length > n || !window.sqmap.sweep.running, before, 400000);
    const rows = await page.evaluate((n) => window.sqmap.sweep.kept[n]?.rows ?? [], before);
    if (rows.length >= depths) return rows;
    assert.ok(tries < 3, await page.textContent('#sweep-words'));
    if (rows.length) await page.evaluate(() => window.sqmap.sweep.kept.pop());
  }
};

test('one button sweeps the press over 20 depths: a plot that grows, a table, a drawing', async () => {
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  await feel(page, 0, 0.02);
  await page.mouse.up();
  const press = await page.evaluate(() => window.sqmap.hand.press);
  await page.click('#sweep');
  await until(page, () => window.sqmap.sweep.running && document.querySelectorAll('#sweep-plot circle').length >= 3);
  assert.match(await page.textContent('#sweep-words'), /^\d+ of 20 depths/, 'it grows while it goes on');
  await page.click('#sweep');  // and can be ended
  assert.match(await page.textContent('#sweep-words'), /Ended/);
  await page.click('#sweep-clear');
  assert.ok(await page.isHidden('#sweep-plot'));
  const rows = await sweep(), { limit, settings } = await page.evaluate(() => window.sqmap.status());
  assert.deepEqual(rows.map((r) => Math.round(1e4 * r.press)), Array.from({ length: 20 }, (_, i) => 10 * (i + 1)), '1 to 20 mm');
  for (const r of rows) {
    const wanted = Math.min(settings.stiffness * r.depth, limit);
    assert.ok(Math.abs(r.force - wanted) < 0.03 * wanted, `${1000 * r.press} mm: ${r.force} N at ${1000 * r.depth} mm, wanted ${wanted}`);
    assert.ok(!r.still || r.spread < 0.01, `${r.spread}`);
  }
  rows.forEach((r, i) => assert.ok(i === 0 || (r.depth > rows[i - 1].depth && r.force > rows[i - 1].force - 0.01)));
  assert.ok(rows.at(-1).limited && !rows[0].limited);
  assert.match(await page.textContent('#sweep-words'), /20 depths, 2\.\d\d N at [\d.]+ mm; 5\d\d N\/m below the limit; at the force limit from [\d.]+ mm on|20 depths, [\d.]+ N at [\d.]+ mm; 49\d N\/m/);
  assert.equal(await page.evaluate(() => window.sqmap.hand.press), press, 'the press is the user’s again');
  assert.ok(!(await page.evaluate(() => window.sqmap.hand.holding)));
  await page.locator('#sweep-plot').screenshot({ path: path.join(folder, 'sweep.png') });

  const [name, table] = await download('#sweep-table'), lines = table.trim().split('\n').map((l) => l.replace(/"[^"]*"/g, 'quoted').split(','));
  assert.equal(name, 'force-depth.csv');
  assert.equal(lines.length, 21);
  const column = (title) => lines.slice(1).map((l) => Number(l[lines[0].indexOf(title)]));
  column('force_N').forEach((x, i) => assert.ok(Math.abs(x - rows[i].force) < 1e-4));
  column('depth_mm').forEach((x, i) => assert.ok(Math.abs(x - 1000 * rows[i].depth) < 1e-3));
  const [svgName, svg] = await download('#sweep-drawing');
  assert.equal(svgName, 'force-depth.svg');
  const drawn = await page.evaluate((text) => {
    const all = new DOMParser().parseFromString(text, 'image/svg+xml');
    return { fault: all.querySelector('parsererror')?.textContent ?? '', circles: all.querySelectorAll('circle').length, text: [...all.querySelectorAll('text')].map((t) => t.textContent).join(' | ') };
  }, svg);
  assert.equal(drawn.fault, '');
  assert.equal(drawn.circles, 20);
  assert.match(drawn.text, /depth of the tool, mm.*force, N.*N\/m, limit/);
});

test('a second sweep stands beside the first, and Space stops one and keeps its depths', async () => {
  await page.locator('#s-stiffness').fill('200');
  await until(page, () => window.sqmap.status().settings.stiffness === 200);
  const rows = await sweep();
  assert.ok(rows.every((r) => Math.abs(r.force - Math.min(200 * r.depth, 2)) < 0.06));
  assert.equal(await page.evaluate(() => document.querySelectorAll('#sweep-plot circle').length), 40);
  await page.locator('#s-stiffness').fill('500');
  await until(page, () => window.sqmap.status().settings.stiffness === 500);
  await page.click('#sweep');
  await until(page, () => /^[3-9] of 20/.test(document.querySelector('#sweep-words').textContent));
  await page.focus('#stage');
  await page.keyboard.press('Space');
  await until(page, () => !window.sqmap.sweep.running);
  const kept = await page.evaluate(() => window.sqmap.sweep.kept.at(-1).rows.length);
  assert.ok(kept >= 3 && kept < 20);
  await page.click('#resume');
  await until(page, () => !window.sqmap.status().stopped);
});

test('the program computes a recording of the page again, to the bit, and draws it', async () => {
  await page.click('#record');
  await feel(page, 0, 0.2);
  await page.waitForTimeout(300);
  await page.mouse.up();
  await page.click('#record');
  const [, text] = await download('#save-recording'), at = path.join(folder, 'again');
  fs.mkdirSync(at, { recursive: true });
  fs.writeFileSync(path.join(at, 'touch.csv'), text);
  const replay = (...options) => spawnSync(sqmap, ['replay', path.join(at, 'touch.csv'), ...options], { encoding: 'utf8' });
  const without = replay();
  assert.equal(without.status, 2);
  assert.match(without.stderr, /recording of dumbbell \(model [0-9a-f]{16}\).*beside it\n {2}cure: save dumbbell\.sqmap by Export in the page/s);
  const names = await page.evaluate(() => window.sqmap.facts().map((f) => f.name));
  for (const [i, name] of names.entries()) {
    const model = await page.evaluate(async (k) => {
      const token = new URLSearchParams(location.search).get('token'), bytes = new Uint8Array(await (await fetch(`/api/object/${k}/sqmap?token=${token}`)).arrayBuffer());
      return btoa(Array.from(bytes, (b) => String.fromCharCode(b)).join(''));
    }, i);
    fs.writeFileSync(path.join(at, `model-${name}.sqmap`), Buffer.from(model, 'base64'));  // found by its content, whatever its name
  }
  const lost = Number(/"lost":(\d+)/.exec(text)[1]), beside = replay('--threads', '2', '--plot', path.join(at, 'touch.svg'));
  if (lost === 0) {
    assert.match(beside.stdout, /ticks, all bit-identical; forces [0-9a-f]{16}/, beside.stdout + beside.stderr);
    assert.equal(beside.status, 0);
  }
  assert.match(beside.stdout, /2 threads: all the same forces/);
  assert.ok(fs.readFileSync(path.join(at, 'touch.svg'), 'utf8').includes('force'));
  const ticks = Number(/(\d+) ticks/.exec(beside.stdout)[1]);
  assert.equal(ticks, text.split('\n').filter((l) => /^[\d.e+-]+,/.test(l)).length, 'every row');
  const files = names.map((name) => path.join(at, `model-${name}.sqmap`));
  assert.equal(replay('--model', ...files.slice(1)).status, 2, 'not all of them');
  assert.equal(replay('--model', ...files).stdout.includes('bit-identical'), lost === 0);
  const against = replay('--against', files[1], '--diff');
  assert.match(against.stderr, /of \d+ ticks differ/);
  assert.match(against.stdout, /^line,time,columns/);
  // A digit that somebody has changed is found.
  const rows = text.split('\n'), head = rows.findIndex((l) => l.startsWith('time,')), row = rows.length - 30, cells = rows[row].split(','), column = rows[head].split(',').indexOf('depth');
  cells[column] = String(Number(cells[column]) + 1e-9);
  rows[row] = cells.join(',');
  fs.writeFileSync(path.join(at, 'touch.csv'), rows.join('\n'));
  const changed = replay();
  assert.match(changed.stdout, new RegExp(`first on line ${lost ? '\\d+' : row + 1}, .*: depth`));
  assert.equal(changed.status, 1);
});

test('a recording of sqmap touch opens with its ticks and forces', async () => {
  const at = path.join(folder, 'again'), made = path.join(at, 'program.csv'), name = (await page.evaluate(() => window.sqmap.facts()))[0].name;
  execFileSync(sqmap, ['touch', '--object', path.join(at, `model-${name}.sqmap`), '--device', 'press', '--seconds', '1', '--record', made], { stdio: 'ignore' });
  const lines = fs.readFileSync(made, 'utf8').split('\n'), head = lines.find((l) => l.startsWith('time,')).split(','), rows = lines.filter((l) => /^[\d.e+-]+,/.test(l)).map((l) => l.split(',').map(Number)).filter((r) => !(r[head.indexOf('input')] & 4));
  await page.setInputFiles('#recording-file', made);
  await until(page, () => /ready to replay\. sqmap touch recorded it/.test(document.querySelector('#notice').textContent));
  const shown = await page.evaluate(() => window.sqmap.recorder.kept.map((k) => [k.frame.ticks.length / 5, Math.hypot(...k.frame.force), k.frame.contacts, k.frame.object]));
  assert.equal(shown.reduce((sum, [ticks]) => sum + ticks, 0), rows.length, 'every tick');
  const largest = (all) => all.reduce((a, b) => Math.max(a, b), 0), sent = ['x', 'y', 'z'].map((k) => head.indexOf(`z0_sent_f${k}`));
  assert.ok(largest(shown.map(([, force]) => force)) <= largest(rows.map((r) => Math.hypot(...sent.map((k) => r[k])))) + 1e-5);
  assert.ok(Math.abs(shown.at(-1)[1] - Math.hypot(...sent.map((k) => rows.at(-1)[k]))) < 1e-5, 'the last force is the one that was sent');
  assert.ok(shown.some(([, , contacts, object]) => contacts > 0 && object === 0), 'the object is touched where it stands now');
});

test('every contact is a span, however short: of ticks, not of pictures', async () => {
  const spans = await page.evaluate(() => {
    const { recorder } = window.sqmap, TICKS = 16;
    // Two taps within one frame, and one of a single tick at another frame's end, as a servo sends them.
    const frame = (time, deep, contacts) => ({ tool: [0, 0, 0], hand: [0, 0, 0], turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], force: [0, 0, 0], torque: [0, 0, 0], point: [0, 0, 0], normal: [0, 0, 1], depth: 0, contacts, object: 0, part: 0, acted: 0, faults: 0, late: 0, degraded: false, engaged: true, connected: true, time, recorded: 0,
      ticks: Float32Array.from(Array.from({ length: TICKS }, (_, i) => (deep.includes(i) ? [0.2, 0, 4e-4, 20, i / 1000] : [0, 0, 0, 20, i / 1000])).flat()) });
    recorder.take([frame(0, [], 0), frame(0.016, [3, 4, 5, 10], 0), frame(0.032, [15], 1), frame(0.048, [], 0), frame(0.064, [], 1), frame(0.08, [], 0)]);
    const out = recorder.spans();
    recorder.take([]);
    return out.filter((s) => s.kind === 'contact').map((s) => [s.from, s.to].map((t) => Math.round(1000 * t)));
  });
  // The last frame but one touches without any depth: a tool that rests.
  assert.deepEqual(spans, [[19, 22], [26, 27], [47, 48], [79, 80]]);
});

test('a stiffness that is set while the tool is held is the one set before, in the servo of a busy machine', async () => {
  await page.evaluate(() => { window.sqmap.world.frame(0); window.sqmap.hand.press = 0.0045; window.sqmap.hand.deeper(0); });
  await settled(page);
  const set = (k) => page.evaluate((x) => { const e = document.querySelector('#s-stiffness'); e.value = x; e.dispatchEvent(new Event('input')); }, k);
  /// Mean and standard deviation of the force over half a second of ticks; null where a fault has ended it.
  const measured = (k) => page.evaluate(async (x) => {
    const { frame, status } = window.sqmap, ticks = [], wait = (ms) => new Promise((r) => setTimeout(r, ms));
    for (let n = 0; status().settings.stiffness !== x; ++n) { if (n > 1000) return null; await wait(20); }
    const begun = frame().time;
    while (frame().time < begun + 1.5) { if (frame().faults || !frame().contacts) return null; await wait(20); }
    for (let last = frame().time, to = last + 0.5; last < to;) {
      const f = frame();
      if (f.faults || !f.contacts) return null;
      if (f.time > last) { last = f.time; for (let i = 0; i < f.ticks.length; i += 5) ticks.push(f.ticks[i]); }
      await wait(4);
    }
    const mean = ticks.reduce((a, b) => a + b, 0) / ticks.length;
    return { mean, sd: Math.sqrt(ticks.reduce((a, b) => a + (b - mean) ** 2, 0) / ticks.length) };
  }, k);
  const again = async (attempt) => {
    for (let tries = 0; tries < 6; ++tries) {
      const out = await attempt();
      await page.mouse.up();
      await page.waitForTimeout(300);
      if (out) return out;
    }
    return assert.fail('the servo keeps finding faults');
  };
  const sequence = [50, 100, 250, 500, 1000, 1500, 500], afresh = new Map();
  for (const k of new Set(sequence)) { await set(k); afresh.set(k, (await again(async () => { await feel(page, 0, 0.02); return measured(k); })).mean); }
  const held = await again(async () => {
    await set(sequence[0]);
    await feel(page, 0, 0.02);
    const out = [];
    for (const k of sequence) { await set(k); const m = await measured(k); if (!m) return null; out.push(m); }
    return out;
  });
  console.log(`      ${sequence.map((k, i) => `${k} N/m: ${held[i].mean.toFixed(3)} N, ${(100 * (held[i].mean / afresh.get(k) - 1)).toFixed(2)} % from afresh, sd ${((100 * held[i].sd) / held[i].mean).toFixed(2)} %`).join('; ')}`);
  sequence.forEach((k, i) => {
    assert.ok(Math.abs(held[i].mean / afresh.get(k) - 1) <= 0.03, `${k} N/m: ${held[i].mean} N, afresh ${afresh.get(k)} N`);
    assert.ok(held[i].sd <= 0.01 * held[i].mean, `${k} N/m: standard deviation ${held[i].sd} of ${held[i].mean} N`);
  });
});

test('one choice bakes the other kind of maps and shows both side by side', async () => {
  await page.click('#tab-look');
  const count = await page.evaluate(() => window.sqmap.facts().length);
  await page.selectOption('#beside', 'twin');
  assert.match(await page.textContent('#notice'), /^Baking \w+ with the paper’s maps, too: both stand side by side then\./);
  await until(page, (n) => window.sqmap.facts().length === n + 1 && window.sqmap.world.objects.ready(), count);
  await page.waitForSelector('#sides:not([hidden])');
  assert.deepEqual((await page.$$eval('#sides span', (all) => all.map((e) => e.textContent))).sort(), ['Central maps', 'The paper’s maps']);
  // It is there once: choosing it again bakes nothing.
  await page.selectOption('#beside', 'none');
  await page.selectOption('#beside', 'twin');
  await page.waitForSelector('#sides:not([hidden])');
  assert.equal(await page.evaluate(() => window.sqmap.facts().length), count + 1);
  await settled(page);
  await page.screenshot({ path: path.join(folder, 'both-maps.png') });
});

test('all that a page asks for is there', async () => {
  const other = await page.context().browser().newPage(), missing = [];
  other.on('response', (r) => { if (r.status() >= 400) missing.push(`${r.status()} ${r.url()}`); });
  other.on('console', (m) => { if (/404|Failed to load/.test(m.text())) missing.push(m.text()); });
  await other.goto(url);
  await other.waitForSelector('body[data-ready]');
  for (const tab of ['look', 'recognise', 'touch']) await other.click(`#tab-${tab}`);
  await other.waitForTimeout(500);
  assert.deepEqual(missing, []);
  await other.close();
});

await run(() => page);
