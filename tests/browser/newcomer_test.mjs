// The first minute and what can go wrong in it: a newcomer without a manual, a lost program, a browser without WebGL, keys alone.
// usage: node newcomer_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { browser, drop, feel, folder, launch, onSurface, openPage, run, settled, sqmap, start, test, until } from './harness.mjs';

// A home of its own: a restart on a named port keeps the address by a file there.
process.env.XDG_STATE_HOME = path.join(folder, 'state');
let { program, url } = await start();
const wide = { viewport: { width: 1360, height: 800 } };
let page;

test('it opens on Touch: one object large, one invitation, and a press is felt', async () => {
  // The page says its purpose before its script has loaded.
  assert.match(await (await fetch(url)).text(), /id="purpose">Touch a 3D object and feel its force\./);
  page = await openPage(url, wide);
  await settled(page);
  assert.equal(await page.getAttribute('#tab-touch', 'aria-selected'), 'true');
  assert.ok(await page.isVisible('#invite'));
  assert.match(await page.textContent('#invite'), /press and drag on me/i);
  const first = await page.evaluate(() => { const s = window.sqmap, i = s.world.objects.focus, b = s.world.objects.box(i), lo = s.world.project(b.min), hi = s.world.project(b.max); return { i, tall: Math.abs(hi.y - lo.y), wide: Math.abs(hi.x - lo.x) }; });
  assert.ok(Math.max(first.tall, first.wide) > 0.8, `it fills the view: ${JSON.stringify(first)}`);
  await feel(page, first.i, 0.3);
  assert.ok(await page.isHidden('#invite'));
  // The tool is drawn on the surface, the hand below it, and the number beside the arrow.
  await until(page, () => window.sqmap.world.tool.springNow() > 0.0005 && /^\d\.\d N$/.test(document.querySelector('.force-tag').textContent));
  await page.screenshot({ path: path.join(folder, 'first-touch.png') });
  await page.mouse.up();
});

test('nothing of the first minute needs scrolling, and each task takes five actions or fewer', async () => {
  for (const id of ['#material', '#s-press', '#s-stiffness', '#s-friction', '#record', '#open', '#export', '#sound-button', '#help']) {
    const box = await (await page.$(id)).boundingBox();
    assert.ok(box && box.y >= 0 && box.y + box.height <= 800, `${id} is in sight`);
  }
  // Feel a stone: one action.
  await page.selectOption('#material', 'stone');
  await until(page, () => window.sqmap.status().settings.stiffness === 1500);
  await page.selectOption('#material', 'rubber');
  await until(page, () => window.sqmap.status().settings.stiffness === 350 && window.sqmap.status().settings.friction === 0.9);
  await page.selectOption('#material', 'plain');
  await until(page, () => window.sqmap.status().settings.stiffness === 500 && window.sqmap.status().settings.friction === 0.3);
  // The worst error: tab, colour, and the legend goes there. Its numbers come first in the panel.
  await page.click('#tab-look');
  await page.selectOption('#colour', 'error');
  await page.waitForSelector('#worst:not([hidden])');
  await settled(page);
  const told = /^Worst triangle: (missed|[\d.e-]+ %), (.+): show it$/.exec(await page.textContent('#worst'));
  await page.click('#worst');
  const numbers = await page.textContent('#numbers');
  assert.ok(numbers.includes(`Object${told[2]}`) && numbers.includes(`Depth error${told[1]}`), `${told[0]}: ${numbers}`);
  const seen = await page.evaluate(() => { const s = window.sqmap, p = s.world.tool.marked(), q = s.world.project(p), hit = s.world.cast(q.x, q.y), errors = s.facts().map((_, i) => { let worst = 0; for (let t = 0; t < s.facts()[i].triangles; ++t) { const e = s.world.objects.fieldAt(i, 'error', t); worst = e === -1 || worst === -1 ? -1 : Math.max(worst, e ?? 0); } return worst; }); return { q: [q.x, q.y], off: hit ? 1000 * hit.point.distanceTo(p) : 99, errors }; });
  assert.ok(Math.hypot(...seen.q) < 0.2 && seen.off < 2, `it is in the middle, and nothing is before it: ${JSON.stringify(seen)}`);
  assert.equal(told[1] === 'missed', seen.errors.includes(-1));
  if (told[1] !== 'missed') assert.ok(Math.abs(parseFloat(told[1]) - Math.max(...seen.errors)) < 0.01 * Math.max(...seen.errors));
  const first = await (await page.$('#numbers')).boundingBox();
  assert.ok(first.y > 0 && first.y + first.height < 500, 'the numbers stand at the top');
  await page.selectOption('#colour', 'parts');
  await page.focus('#stage');
  await page.keyboard.press('Home');
  // Record and share: record, touch, stop, save.
  await page.click('#tab-touch');
  await settled(page);
  await page.click('#record');
  await feel(page, 0, 0.2);
  await page.waitForTimeout(300);
  await page.mouse.up();
  await page.click('#record');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-recording')]);
  const to = path.join(folder, 'newcomer.csv');
  await download.saveAs(to);
  // Every tick has a time of its own, by the servo's clock.
  const times = fs.readFileSync(to, 'utf8').trim().split('\n').filter((r) => /^[\d.]/.test(r)).map((r) => Number(r.split(',')[0]));
  assert.ok(times.length > 100 && new Set(times).size === times.length && times.every((t, i) => i === 0 || t > times[i - 1]));
});

test('STOP means the same everywhere, and two presses of Space do not undo it', async () => {
  await feel(page, 0, 0.2);
  await page.keyboard.press('Space');
  await until(page, () => window.sqmap.status().stopped);
  await page.mouse.up();
  assert.equal(await page.evaluate(() => document.activeElement.id), 'resume');
  await page.keyboard.press('Space');
  await page.waitForTimeout(200);
  assert.ok(await page.evaluate(() => window.sqmap.status().stopped));
  await page.keyboard.press('Enter');
  await until(page, () => !window.sqmap.status().stopped);
  // A slider that has the focus gives it up to Resume, and has it again.
  await page.focus('#stage');
  await page.keyboard.press('Enter');
  await until(page, () => window.sqmap.frame()?.contacts > 0);
  await page.focus('#s-stiffness');
  await page.keyboard.press('Space');
  await until(page, () => window.sqmap.status().stopped && document.activeElement.id === 'resume');
  await page.keyboard.press('Enter');
  await until(page, () => !window.sqmap.status().stopped && document.activeElement.id === 's-stiffness');
  await page.click('#tab-look');
  assert.ok(await page.isHidden('#stop'), 'where nothing can be felt it is not offered');
});

test('nothing streams in Look', async () => {
  await until(page, () => !window.sqmap.status().touching);
  const count = () => page.evaluate(() => window.sqmap.frames());
  const before = await count();
  await page.waitForTimeout(500);
  assert.equal(await count(), before);
});

test('tab, view and selection survive a reload, and Back goes back', async () => {
  await page.click('#tab-look');
  await page.evaluate(() => { window.sqmap.world.frame(1); });
  await page.selectOption('#colour', 'protrusion');
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 1)));
  await until(page, () => document.querySelector('#part-name'));
  const pose = await page.evaluate(() => window.sqmap.world.pose());
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  assert.equal(await page.getAttribute('#tab-look', 'aria-selected'), 'true');
  (await page.evaluate(() => window.sqmap.world.pose())).forEach((c, i) => assert.ok(Math.abs(c - pose[i]) < 2e-3));
  assert.ok(await page.isVisible('#part-name'));
  assert.equal(await page.evaluate(() => window.sqmap.world.objects.colourBy), 'protrusion');
  await page.selectOption('#colour', 'parts');
  await page.click('#tab-recognise');
  await page.goBack();
  assert.equal(await page.getAttribute('#tab-look', 'aria-selected'), 'true');
});

test('several files are queued, and a dialog says how they are read', async () => {
  const file = path.join(folder, 'box.obj');
  execFileSync(sqmap, ['shapes', 'rounded_box', '-o', file]);
  execFileSync(sqmap, ['shapes', 'torus', '-o', path.join(folder, 'torus.obj')]);
  const text = fs.readFileSync(file, 'utf8');
  const lines = text.trim().split('\n');
  await drop(page, ['one.obj', text], ['two.obj', lines.slice(0, -1).join('\n') + '\n'], ['bad.off', 'OFF\n1 0 0\n0 0 0\n']);
  await until(page, () => document.querySelectorAll('#queue li').length === 3);
  await until(page, () => window.sqmap.facts().length === 4 && document.querySelectorAll('#queue li')[2].textContent.includes('✗'));
  assert.match(await page.textContent('#queue'), /one\.obj.*✓.*two\.obj.*✓.*bad\.off.*✗/s);
  assert.ok(!(await page.isVisible('#queue button')), 'what is baked or refused cannot be cancelled any more');
  // The choices are there before a file is.
  await page.click('#close-verdict');
  await page.click('#reading');
  assert.ok(await page.isVisible('#thickness') && (await page.evaluate(() => document.activeElement.id)) === 'repair');
  assert.match(await page.textContent('#verdict'), /64 MB and 500,000 faces/);
  // A sheet is refused, in the words of the choices; with a thickness it is a plate, and read again it stays one object.
  await drop(page, ['sheet.obj', 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n']);
  await page.waitForSelector('#verdict.bad');
  const words = await page.textContent('#verdict');
  assert.match(words, /What helps: make it a plate with \u201cSheets are\u201d: T, T at least [\d.e-]+, or/);
  assert.ok(!words.includes('--'), words);
  for (const thick of ['0.1', '0.3']) {
    await page.fill('#thickness', thick);
    await page.click('text=Read sheet.obj again');
    await until(page, (t) => { const all = window.sqmap.facts().filter((f) => f.name === 'sheet'), least = all.length && Math.min(...all[0].half) / Math.max(...all[0].half); return all.length === 1 && all[0].solid && Math.abs(least - t) < 0.02; }, Number(thick));
  }
  // Refused this time, it keeps the object that it has.
  await page.fill('#thickness', '');
  await page.click('text=Read sheet.obj again');
  await page.waitForSelector('#verdict.bad');
  assert.equal(await page.evaluate(() => window.sqmap.facts().filter((f) => f.name === 'sheet').length), 1);
  await until(page, () => window.sqmap.world.objects.focus === window.sqmap.facts().length - 1, undefined);
  await page.click('#close-verdict');
  await page.click('#remove-all');
  await until(page, () => window.sqmap.facts().length === 0);
});

test('keys: F1 lists them, letters work with Shift, and Enter over nothing says where to go', async () => {
  await page?.close();
  page = await openPage(url, wide);
  await drop(page, ['box.obj', fs.readFileSync(path.join(folder, 'box.obj'), 'utf8')]);
  await until(page, () => window.sqmap.facts().length === 1 && window.sqmap.world.objects.ready());
  await page.keyboard.press('F1');
  await page.waitForSelector('#keys[open]');
  assert.equal(await page.evaluate(() => document.querySelector('#keys').scrollTop), 0, 'they begin at the top');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#keys[open]', { state: 'detached' });
  await page.evaluate(() => { window.said = []; const live = document.querySelector('#live'); new MutationObserver(() => window.said.push(live.textContent)).observe(live, { childList: true }); });
  // The object in the upper right corner of the view.
  await page.evaluate(() => { const w = window.sqmap.world, t = w.controls.target; w.zoom(2.2); t.x -= 0.35; t.y -= 0.22; w.controls.update(); w.turn(0, 0); });
  await page.focus('#stage');
  await page.keyboard.press('Enter');
  await until(page, () => window.said.some((t) => /^Nothing here: box is /.test(t)));
  assert.match((await page.evaluate(() => window.said)).join('|'), /Nothing here: box is (up and )?right/);
  await page.keyboard.press('Enter');  // lifted
  await page.evaluate(() => window.sqmap.world.frame(0));
  await page.keyboard.press('Shift+E');
  await until(page, () => window.said.includes('Turned 15 degrees right'));
  await page.keyboard.press('Enter');
  // Hidden inputs of files are no tab stops.
  assert.deepEqual(await page.$$eval('input[type=file]', (all) => all.map((e) => [e.hidden, !!e.getAttribute('aria-label')])), [[true, true], [true, true]]);
});

test('keys alone lead to an object: words say where it is and that it comes nearer, until it is touched', async () => {
  if (await page.evaluate(() => window.sqmap.hand.holding)) await page.keyboard.press('Enter');
  await page.evaluate(() => { const w = window.sqmap.world, t = w.controls.target; w.frame(0); w.zoom(2.2); t.x -= 0.35; t.y -= 0.22; w.controls.update(); w.turn(0, 0); window.said = []; });
  await page.evaluate(() => { window.guided = []; const s = window.sqmap, seek = s.hand.onSeek; s.hand.onSeek = (object, distance, direction) => { window.guided.push([object, distance, direction]); seek(object, distance, direction); }; });
  await page.keyboard.press('Enter');
  const way = () => page.evaluate(() => window.guided.at(-1));
  const first = await way();
  assert.ok(first[0] === 0 && first[1] > 0.05 && /up|right/.test(first[2]), JSON.stringify(first));
  let distance = first[1];
  for (let i = 0; i < 200; ++i) {
    const [object, far, words] = await way();
    if (object === null) break;
    assert.ok(far < distance + 0.03, `as it says it comes nearer: ${distance} to ${far}`);
    distance = far;
    // As the words say; close by, where it was last.
    const key = /up/.test(words) ? 'ArrowUp' : /down/.test(words) ? 'ArrowDown' : /left/.test(words) ? 'ArrowLeft' : 'ArrowRight';
    await page.keyboard.press(key);
  }
  assert.equal((await way())[0], null, 'the words led to it');
  await until(page, () => window.sqmap.frame()?.contacts > 0 && window.sqmap.frame().object === 0);
  assert.ok((await page.evaluate(() => window.said)).filter((t) => /^Nothing here: box is /.test(t)).length > 1);
  await page.keyboard.press('Enter');
});

test('of two objects that overlap on the screen the one that is clicked comes forward, and the other fades', async () => {
  await drop(page, ['torus.obj', fs.readFileSync(path.join(folder, 'torus.obj'), 'utf8')]);
  await until(page, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());
  await page.click('#tab-look');
  // From the side one hides the other.
  await page.focus('#stage');
  await page.keyboard.press('Home');
  await page.click('#view-right');
  await settled(page);
  assert.ok(await page.evaluate(() => window.sqmap.world.crowded(0) && window.sqmap.world.crowded(1)));
  const hue = (object) => page.evaluate((i) => { const c = window.sqmap.world.objects.surfaces()[i].geometry.attributes.color.array; let sum = 0; for (let k = 0; k < c.length; k += 3) sum += Math.max(c[k], c[k + 1], c[k + 2]) - Math.min(c[k], c[k + 1], c[k + 2]); return (3 * sum) / c.length; }, object);
  const before = [await hue(0), await hue(1)];
  const front = await page.evaluate(() => window.sqmap.world.cast(0, 0)?.object ?? window.sqmap.world.cast(0.1, 0)?.object ?? 0);
  const at = await onSurface(page, front), direction = await page.evaluate(() => window.sqmap.world.direction().toArray());
  await page.mouse.click(...at);
  await until(page, (i) => window.sqmap.world.objects.focus === i, front);
  const size = await page.evaluate((i) => { const s = window.sqmap.world, b = s.objects.box(i), lo = s.project(b.min), hi = s.project(b.max); return { across: Math.max(Math.abs(lo.x - hi.x), Math.abs(lo.y - hi.y)), middle: s.project(b.getCenter(b.min.clone())).length() }; }, front);
  assert.ok(size.across > 0.8 && size.middle < 0.05, `it is framed: ${JSON.stringify(size)}`);
  (await page.evaluate(() => window.sqmap.world.direction().toArray())).forEach((x, i) => assert.ok(Math.abs(x - direction[i]) < 1e-3, 'seen from the same side'));
  assert.ok((await hue(1 - front)) < 0.7 * before[1 - front], 'the other fades');
  // The page says beside the point what was clicked.
  const tag = await (await page.$('#pick-tag')).boundingBox(), marked = await page.evaluate(() => { const s = window.sqmap.world, p = s.pixel(s.tool.marked()), b = document.querySelector('#stage').getBoundingClientRect(); return [b.left + p.x, b.top + p.y]; });
  assert.ok(Math.hypot(Math.max(tag.x - marked[0], 0, marked[0] - tag.x - tag.width), Math.max(tag.y - marked[1], 0, marked[1] - tag.y - tag.height)) < 40, 'beside the click');
  assert.match(await page.textContent('#pick-tag'), /-?[\d.]+, -?[\d.]+, -?[\d.]+$/);
});

test('the page is saved as one file that needs no program', async () => {
  page ??= await openPage(url, wide);
  await page.click('#tab-touch');
  await page.evaluate(() => window.sqmap.world.frame(0));
  await settled(page);
  await page.click('#record');
  await feel(page, 0, 0.2);
  await page.waitForTimeout(400);
  const force = await page.evaluate(() => Math.hypot(...window.sqmap.frame().force));
  await page.mouse.up();
  await page.click('#record');
  // Any moment of it, standing still.
  await page.locator('#scrub').fill((Math.floor(10 * (await page.evaluate(() => window.sqmap.recorder.seconds))) / 10).toFixed(1));
  assert.ok(await page.evaluate(() => window.sqmap.recorder.paused && window.sqmap.recorder.spans().some((m) => m.kind === 'contact')));
  await page.click('#to-now');
  await page.evaluate(() => { document.querySelector('#export').open = true; });
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-page')]);
  const file = path.join(folder, 'saved.html');
  await download.saveAs(file);
  const alone = await browser.newPage({ viewport: wide.viewport }), asked = [];
  alone.on('request', (r) => { if (!/^(file|data|blob):/.test(r.url())) asked.push(r.url()); });
  await alone.goto(`file://${path.resolve(file)}`);
  await alone.waitForSelector('body[data-ready]');
  assert.deepEqual(await alone.evaluate(() => [window.sqmap.facts().length, window.sqmap.world.objects.ready(), document.querySelector('#connection').textContent]), [await page.evaluate(() => window.sqmap.facts().length), true, 'a saved page']);
  // Somewhere in it, whatever the machine's pace, there is the arrow of what was felt.
  await alone.click('#replay');
  assert.ok(await alone.evaluate((f) => { const { recorder, world } = window.sqmap; for (let t = 0; t <= recorder.seconds; t += 0.02) { recorder.seek(t); if (world.tool.arrowNow().length > 0.01 * f) return true; } return false; }, force));
  await alone.screenshot({ path: path.join(folder, 'saved.png') });
  assert.deepEqual(asked, []);
  // It offers what it can do: to look, and to replay.
  assert.deepEqual(await alone.$$eval('.tabs button:not([hidden])', (all) => all.map((b) => b.textContent)), ['Replay', 'Look']);
  assert.deepEqual(await alone.$$eval('#panel .card', (all) => all.filter((c) => c.checkVisibility()).map((c) => c.querySelector('h2, summary').textContent).slice(0, 1)), ['Recording']);
  await alone.close();
  // Without a recording it opens on Look.
  const fresh = await openPage(url, wide);
  await until(fresh, () => window.sqmap.recorder.count > 0);  // which the program keeps
  await fresh.evaluate(() => { window.sqmap.recorder.kept = []; document.querySelector('#export').open = true; });
  const [still] = await Promise.all([fresh.waitForEvent('download'), fresh.click('#save-page')]);
  await still.saveAs(file);
  await fresh.close();
  const seen = await openPage(`file://${path.resolve(file)}`, wide);
  assert.deepEqual(await seen.$$eval('.tabs button:not([hidden])', (all) => all.map((b) => [b.textContent, b.getAttribute('aria-selected')])), [['Look', 'true']]);
  // The worst error is found there, too; what needs the program is not offered.
  await seen.selectOption('#colour', 'error');
  await seen.waitForSelector('#worst:not([hidden])');
  await seen.click('#worst');
  assert.match(await seen.textContent('#numbers'), /Depth error/);
  assert.ok(await seen.isHidden('#notice'));
  assert.deepEqual(await seen.$$eval('#split, #merge, #remove, #remove-all, #slice, #samples, #inspect:not([hidden])', (all) => all.map((e) => e.id)), []);
  await seen.close();
});

test('a recording outlives the page and the program: opened later it is replayed, and computed over other objects', async () => {
  const model = (name) => path.join(folder, `${name}.sqmap`);
  for (const [shape, name] of [['rounded_box', 'box'], ['torus', 'torus']]) {
    execFileSync(sqmap, ['shapes', shape, '-o', path.join(folder, `${name}.obj`)]);
    execFileSync(sqmap, ['bake', path.join(folder, `${name}.obj`), '-o', model(name)], { stdio: 'ignore' });
  }
  const one = await start(model('box'));
  let later = await openPage(one.url, wide);
  await later.click('#record');
  await feel(later, 0, 0.2);
  await later.selectOption('#material', 'rubber');
  await later.waitForTimeout(500);
  await later.mouse.up();
  await later.click('#record');
  const felt = await later.evaluate(() => { let most = 0; const r = window.sqmap.recorder; for (let t = 0; t <= r.seconds; t += 0.02) { r.seek(t); const a = window.sqmap.world.tool.arrowNow(); if (a.visible) most = Math.max(most, a.length); } document.querySelector('#to-now').click(); return most; });
  const [download] = await Promise.all([later.waitForEvent('download'), later.click('#save-recording')]);
  const file = path.join(folder, 'kept.csv');
  await download.saveAs(file);
  const text = fs.readFileSync(file, 'utf8');
  // Another page of the same program has it at once.
  await later.close();
  later = await openPage(one.url, wide);
  await until(later, () => window.sqmap.recorder.count > 10 && /recorded/.test(document.querySelector('#recording').textContent));
  await later.close();
  one.program.kill();

  const two = await start(model('torus'));
  later = await openPage(two.url, wide);
  await drop(later, ['kept.csv', text]);
  await later.waitForSelector('#verdict.bad');
  assert.match(await later.textContent('#verdict'), /recording of box \(model [0-9a-f]{16}\), which is not open.*What helps: open box\.sqmap/s);
  await later.click('#close-verdict');
  // Beside the torus the box stands elsewhere than it stood: they change places.
  await later.setInputFiles('#file', model('box'));
  await until(later, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());
  assert.notEqual(await later.evaluate(() => window.sqmap.facts()[1].position[0]), 0);
  await later.selectOption('#material', 'stone');
  await until(later, () => window.sqmap.status().settings.stiffness === 1500);
  await drop(later, ['kept.csv', text]);
  await until(later, () => /ready to replay/.test(document.querySelector('#notice').textContent));
  await until(later, () => window.sqmap.status().settings.stiffness === 350 && window.sqmap.world.objects.ready());
  const [torus, box] = await later.evaluate(() => window.sqmap.facts().map((f) => f.position[0]));
  assert.ok(box === 0 && torus > 0.1, `${torus} ${box}`);
  // Any moment of it, with the arrow of then, once all of it is in sight.
  await later.evaluate(() => window.sqmap.world.frame(1));
  const seen = await later.evaluate(() => { let most = 0; const r = window.sqmap.recorder; for (let t = 0; t <= r.seconds; t += 0.02) { r.seek(t); const a = window.sqmap.world.tool.arrowNow(); if (a.visible) most = Math.max(most, a.length); } return most; });
  assert.ok(Math.abs(seen - felt) < 0.05 * felt, `${seen} as ${felt}`);
  await later.screenshot({ path: path.join(folder, 'reopened.png') });
  const again = async (wanted) => {
    await later.click('#again');
    await until(later, (w) => new RegExp(w).test(document.querySelector('#again-words').textContent) && !document.querySelector('#again').disabled, wanted);
    return later.textContent('#again-words');
  };
  const proof = await again('Replay draws it');
  assert.ok(/the same to the bit|ticks were lost/.test(proof), proof);
  assert.match(await later.textContent('#recording'), /^Standing at [1-9]/, 'it stands where it stood');
  await later.selectOption('#material', 'stone');
  await until(later, () => window.sqmap.status().settings.stiffness === 1500);
  assert.match(await again('differs by at most'), /of now the force differs by at most [\d.]+ N/);
  await later.click('#tab-look');
  await (await later.$$('#facts .object'))[1].click();
  await later.click('#remove');
  await until(later, () => window.sqmap.facts().length === 1);
  await later.click('#tab-touch');
  assert.match(await again('differs by at most'), /same to the bit|lost/, 'without the object the recording keeps it');
  await drop(later, ['cut.csv', text.slice(0, 60)]);
  await later.waitForSelector('#verdict.bad');
  assert.match(await later.textContent('#verdict'), /E_RECORDING/);
  await later.close();
  two.program.kill();
});

test('a slice has the signed distance, parts are left out, two clicks are measured', async () => {
  await page.click('#tab-look');
  await page.evaluate(() => { document.querySelector('#slice').open = true; window.sqmap.world.frame(0); });
  await page.selectOption('#slice-axis', '1');
  await until(page, () => /deepest point of the slice is [\d.]+ mm inside/.test(document.querySelector('#slice-words').textContent));
  await page.waitForTimeout(300);
  await page.screenshot({ path: path.join(folder, 'slice.png') });
  await page.selectOption('#slice-axis', 'off');
  await settled(page);
  const [x, y] = await onSurface(page, 0);
  await page.check('#measure');
  await page.mouse.click(x, y);
  await until(page, () => /second point/.test(document.querySelector('#measured').textContent));
  await settled(page);
  await page.mouse.click(...(await onSurface(page, 0)).map((c) => c + 12));
  await until(page, () => /^[\d.]+ mm/.test(document.querySelector('#measured').textContent));
  await page.uncheck('#measure');
  await page.click('#hide-part');
  const gone = await page.evaluate(() => window.sqmap.world.cast(0, 0));
  assert.equal(gone, null, 'the only part of the object is left out');
  await page.click('#show-parts');
  assert.ok(await page.isHidden('#show-all'));
  assert.ok((await page.evaluate(() => window.sqmap.world.cast(...window.sqmap.world.project(window.sqmap.world.tool.marked()).toArray()))) !== null);
  // With nothing selected there is a way back, too; and what is touched is whole.
  await page.click('#hide-part');
  await page.mouse.click(x - 0.4 * (await page.evaluate(() => window.sqmap.world.size.x)), y);
  assert.match(await page.textContent('#show-all'), /\(1 hidden\)/);
  const there = () => page.evaluate(() => { const s = window.sqmap.world, look = s.objects.surfaces()[0].geometry.attributes.look.array; return look.filter((_, i) => i % 2 === 0).every((v) => v === 255); });
  assert.ok(!(await there()));
  await page.click('#tab-touch');
  assert.ok(await there());
  await page.click('#tab-look');
  assert.ok(!(await there()));
  await page.click('#show-all');
  assert.ok((await there()) && (await page.isHidden('#show-all')));
  const before = await page.evaluate(() => window.sqmap.world.pose());
  await page.focus('#stage');
  await page.keyboard.press('5');
  const top = await page.evaluate(() => window.sqmap.world.pose());
  assert.ok(top[1] - top[4] > 0.99 * Math.hypot(top[0] - top[3], top[1] - top[4], top[2] - top[5]) && top.join() !== before.join());
  await page.keyboard.press('Home');
});

test('a restart on the same port keeps the address; another token says where to look', async () => {
  const port = '47119', one = await start('--port', port), lost = await openPage(one.url, wide);
  await feel(lost, 0, 0.1);
  one.program.kill();
  await until(lost, () => /lost/.test(document.querySelector('#connection').textContent));
  await lost.mouse.up();
  assert.ok(!(await lost.textContent('#notice')).includes('TypeError'));
  const two = await start('--port', port);
  assert.equal(two.url, one.url);
  await until(lost, () => /started anew/.test(document.querySelector('#notice').textContent) && document.querySelector('#connection').textContent === 'connected');
  await until(lost, () => window.sqmap.facts().length === 2 && window.sqmap.world.objects.ready());  // baked after the address is there
  await feel(lost, 0, 0.1);
  await lost.mouse.up();
  const kept = path.join(process.env.XDG_STATE_HOME, 'sqmap', `view-${port}.token`);
  assert.equal(fs.statSync(kept).mode & 0o777, 0o600);
  // Readable by others it is not trusted.
  fs.chmodSync(kept, 0o644);
  two.program.kill();
  await until(lost, () => /lost/.test(document.querySelector('#connection').textContent));
  const three = await start('--port', port);
  assert.notEqual(three.url, one.url);
  await until(lost, () => /only the address that it printed opens it/.test(document.querySelector('#notice').textContent));
  // It is said once, however often the page tries again.
  await lost.click('#answer');
  await lost.evaluate(() => { window.said = 0; new MutationObserver(() => { ++window.said; }).observe(document.querySelector('#live'), { childList: true }); });
  await lost.waitForTimeout(9000);
  assert.deepEqual(await lost.evaluate(() => [window.said, document.querySelector('#notice').hidden, document.querySelector('#connection').textContent]), [0, true, 'another program is running here']);
  await lost.close();
  three.program.kill();
});

test('without WebGL it says so, and keys, numbers and force work', async () => {
  const poor = await launch(['--no-sandbox', '--disable-gpu', '--disable-3d-apis', '--disable-webgl', '--disable-webgl2']);
  const blind = await openPage(url, wide, { from: poor });
  assert.ok(await blind.isVisible('#no-picture'));
  assert.match(await blind.textContent('#no-picture'), /WebGL/);
  await blind.evaluate(() => window.sqmap.world.frame(0));  // a torus has nothing in its middle
  await blind.focus('#stage');
  await blind.keyboard.press('Enter');
  await until(blind, () => window.sqmap.frame()?.contacts > 0 && Math.hypot(...window.sqmap.frame().force) > 0.1);
  await until(blind, () => /N · .* mm deep/.test(document.querySelector('#force').textContent));
  await poor.close();
});

await run(() => page);
