// Tests that a game of recognition is played without eyes: by keys, the accessibility tree and what live regions say, from the start to
// the file of results. The script that plays hears nothing but words, learns five objects in a first game, and names them in a second.
// With ORCA=its program in the environment the words are those that this screen reader speaks, of a window on an X server.
// usage: node blind_test.mjs SQMAP CHROMIUM FOLDER
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { folder, GL, launch, openPage, run, sqmap, start, test, until } from './harness.mjs';

const { ORCA } = process.env, spoken = path.join(folder, 'orca.txt');
if (ORCA) {
  // Its own log is written late; a customization lets it write each line at once. It has no voice: where there is no sound, the
  // synthesizer stops answering, and Orca waits for it without end.
  fs.mkdirSync(path.join(folder, 'orca'));
  fs.writeFileSync(path.join(folder, 'orca/orca-customizations.py'), `import orca.debug as d, orca.speech as s\nd.debugLevel = d.LEVEL_INFO\nd.debugFile = open(${JSON.stringify(spoken)}, "w", buffering=1)\ns.init = lambda: None\n`);
  const reader = spawn(ORCA, { stdio: 'ignore', env: { ...process.env, XDG_DATA_HOME: folder, XDG_CONFIG_HOME: folder } });
  process.on('exit', () => reader.kill('SIGKILL'));
  for (let k = 0; !fs.existsSync(spoken) || !/SPEECH OUTPUT/.test(fs.readFileSync(spoken, 'utf8')); ++k) {
    assert.ok(k < 300 && reader.exitCode === null, 'Orca does not speak');
    await new Promise((resolve) => { setTimeout(resolve, 200); });
  }
}

const SHAPES = ['sphere', 'torus', 'rounded_box', 'dumbbell', 'tapered'];
const models = SHAPES.map((shape) => {
  const mesh = path.join(folder, `${shape}.obj`), model = path.join(folder, `${shape}.sqmap`);
  execFileSync(sqmap, ['shapes', shape, '-o', mesh]);
  execFileSync(sqmap, ['bake', mesh, '-o', model], { stdio: 'ignore' });
  return model;
});
const { url } = await start(...models);
// Small: it is drawn in software.
const page = await openPage(url, { viewport: { width: 1100, height: 480 } }, ORCA ? { from: await launch([...GL, '--force-renderer-accessibility'], false) } : {});
const tree = await page.context().newCDPSession(page);

/// The words of all live regions, in order, or what Orca speaks.
const heard = [];
let read = 0;
const listen = () => {
  const text = fs.readFileSync(spoken, 'utf8'), end = text.lastIndexOf('\n') + 1;
  for (const [, words] of text.slice(read, end).matchAll(/SPEECH OUTPUT: '(.*?)'(?:\{|$)/gm)) heard.push(words);
  read = end;
};
await page.exposeFunction('hearing', (text) => heard.push(text));
if (ORCA) setInterval(listen, 50).unref();
else await page.evaluate(() => {
  for (const region of document.querySelectorAll('[aria-live]:not([aria-live=off]), [role=alert]'))
    new MutationObserver(() => { if (region.textContent) window.hearing(region.textContent); }).observe(region, { childList: true, characterData: true, subtree: true });
});
/// The newest words of that form since a moment; null where none come.
const hears = async (form, since, patience = 4000) => {
  for (const end = Date.now() + patience * (ORCA ? 8 : 1); Date.now() < end; await page.waitForTimeout(40)) {
    const text = heard.slice(since).findLast((t) => form.test(t));
    if (text) return text;
  }
  return null;
};
// It reads the whole page aloud once it is loaded.
if (ORCA) for (let before = -1; before !== heard.length; await page.waitForTimeout(3000)) before = heard.length;
const focusedNode = async () => {
  const { nodes } = await tree.send('Accessibility.getFullAXTree');
  return nodes.findLast((n) => !n.ignored && n.properties?.some((p) => p.name === 'focused' && p.value.value === true));
};
/// Role and name of what has the focus, as a screen reader has them.
const focused = async () => {
  const node = await focusedNode();
  return node ? `${node.role.value} ${node.name?.value ?? ''}`.trim() : '';
};
/// Presses the space bar until the answer that has the focus is said to be chosen. While the tool still touches, Space is STOP: then
/// Resume has the focus, and gives it back.
const choose = async () => {
  for (let k = 0; k < 12; ++k) {
    const node = await focusedNode(), resumes = /^Resume/.test(node?.name?.value ?? '');
    if (!resumes && node?.properties?.some((p) => p.name === 'checked' && String(p.value.value) === 'true')) return;
    await press(resumes ? 'Enter' : 'Space');
    await page.waitForTimeout(150);
  }
};
/// A screen reader that is outrun falls silent: its user waits until it has said where the keyboard is.
const spokenOf = async (since) => { for (let k = 0; ORCA && heard.length === since && k < 40; ++k) await page.waitForTimeout(50); };
const tab = async (wanted, back = false) => {
  for (let k = 0; k < 90; ++k) {
    const name = await focused();
    if (wanted.test(name)) return name;
    if (!name) await page.bringToFront();  // behind the page's last element are the browser's own
    const since = heard.length;
    await page.keyboard.press(back ? 'Shift+Tab' : 'Tab');
    await spokenOf(since);
  }
  return assert.fail(`${wanted} is not reached by Tab`);
};
const press = async (key, times = 1) => { for (let k = 0; k < times; ++k) await page.keyboard.press(key, { delay: ORCA ? 60 : 0 }); };

if (!ORCA) test('tabs and the keys of the stage are announced', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  await tab(/^tab Touch/);
  let since = heard.length;
  await press('ArrowRight');
  assert.match(await focused(), /^tab Look/);
  assert.ok(await hears(/^Look: on the stage arrow keys turn the view/, since));
  await tab(/^application|^Canvas The scene/i);
  since = heard.length;
  await press('ArrowLeft', 3);
  assert.match(await hears(/^Seen from/, since), /^Seen from .*degrees above\.$/);
  await page.evaluate(() => document.activeElement?.blur());
  await tab(/^tab Look/);
  since = heard.length;
  await press('ArrowRight');
  assert.match(await focused(), /^tab Recognise/);
  assert.ok(await hears(/^Recognise: an object is hidden/, since));
});

if (ORCA) test('a screen reader speaks the tabs and the view', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  await tab(/^tab Touch/);
  let since = heard.length;
  await press('ArrowRight');
  assert.ok(await hears(/^Look: on the stage arrow keys turn the view/, since));
  await tab(/^application|^Canvas The scene/i);
  since = heard.length;
  await press('ArrowLeft', 3);
  assert.ok(await hears(/^Seen from .*degrees above\.$/, since));
});

/// The numbers and directions of an answer to N.
const understood = (text) => {
  const [, hour] = /(\d+) o'clock/.exec(text) ?? [], [, third] = /(lower|middle|upper) third/.exec(text) ?? [], [, out] = /(\d+) millimetres? out/.exec(text) ?? [], [, away] = /surface is (\d+)/.exec(text) ?? [], [, push] = /pushes ([a-z ]+)/.exec(text) ?? [];
  return { touches: !text.startsWith('Touching nothing'), hour: Number(hour ?? 0), third: ['lower', 'middle', 'upper'].indexOf(third), out: Number(out ?? 0), away: Number(away ?? 0), push: push ? push.split(' and ') : [] };
};
/// How far two answers are apart, 0 to 2: one that went quite another way, as a tool that slipped into a hole, counts no more.
const apart = (a, b) => {
  if (a.touches !== b.touches) return 2;
  const hours = a.hour && b.hour ? Math.min(Math.abs(a.hour - b.hour), 12 - Math.abs(a.hour - b.hour)) : 0;
  const pushes = a.touches ? a.push.filter((w) => !b.push.includes(w)).length + b.push.filter((w) => !a.push.includes(w)).length : 0;
  return Math.min(Math.min(hours, 3) / 2 + Math.abs(a.third - b.third) + Math.abs(a.out - b.out) / 12 + Math.abs(a.away - b.away) / 12 + pushes / 2, 2);
};
/// Answers to N until two are alike: the tool is at rest then.
const answer = async () => {
  let before = '';
  for (let k = 0; k < 20; ++k) {
    await page.waitForTimeout(250);
    const since = heard.length;
    await press('n');
    const text = (await hears(/newtons|^Touching nothing|on its way down/, since, ORCA ? 300 : 4000)) ?? '';
    const now = text.replace(/[\d.]+ newtons/, '').replace(/, (new|touched before)/, '');
    if (ORCA && before && !text) return before;  // a screen reader does not say the same again
    if (/on its way/.test(text)) continue;
    if (text && now === before) return text;
    before = now;
  }
  return before;
};
/// Takes the tool up, and waits until N says so: while something is touched the space bar is STOP, on answers too.
const lift = async () => {
  await press('Enter');
  for (let k = 0, since = heard.length; k < 20; ++k, since = heard.length) {
    await press('n');
    if (/^Touching nothing$/.test(await hears(/newtons|^Touching nothing/, since, ORCA ? 300 : 4000))) return;
  }
};
// Sentences take their time: a screen reader's game has fewer rounds and positions.
const ROUNDS = ORCA ? 4 : 6, STEPS = 13, PATH = [['ArrowLeft', 'ArrowUp'], ['ArrowRight'], ['ArrowRight'], ['ArrowDown'], ['ArrowLeft'], ['ArrowLeft'], ['ArrowDown'], ['ArrowRight'], ['ArrowRight']].slice(0, ORCA ? 3 : 9);
const SIDES = ORCA ? 1 : 2, QUARTER = 6;  // what is long is a ball from its end: the object is walked round by a quarter
/// Hears the answers at these positions over the hidden object. turns: by 15 degrees, before.
const explored = async (turns) => {
  const out = [];
  for (let side = 0; side < SIDES; ++side) {
    if (side > 0 || turns) await press('e', side > 0 ? QUARTER : turns);
    await press('Enter');
    for (const moves of PATH) {
      for (const move of moves) await press(move, STEPS);
      out.push(understood(await answer()));
    }
    for (const back of ['ArrowLeft', 'ArrowUp']) await press(back, STEPS);  // to the middle
    await lift();
  }
  return out;
};
const known = [];  // [name, what was heard]
/// Known objects, and how far what was heard of each is from this, the nearest first.
const likely = (now) => known.map(([name, then]) => [name, then.reduce((sum, x, k) => sum + apart(x, now[k]), 0)]).sort((a, b) => a[1] - b[1]);

const margins = [];
/// A game; [object, guess] of each round, as it was said.
const game = async (participant, turns) => {
  await tab(/^textbox Name/);
  await page.keyboard.press('Control+A');
  await page.keyboard.type(participant);
  await tab(/^combobox Rounds/);
  await page.keyboard.press('Home');
  await press('ArrowDown', [4, 6].indexOf(ROUNDS));
  await tab(/^combobox Objects/);
  await page.keyboard.press('End');  // balanced
  await tab(/^(button Begin|checkbox A practice)/);
  if (/^checkbox/.test(await focused()) && (await page.isChecked('#practice'))) await press('Space');
  await tab(/^button Begin/);
  let since = heard.length;
  await press('Enter');
  const out = [];
  for (let round = 1; round <= ROUNDS; ++round) {
    assert.match(await hears(/^Round/, since, 20000), new RegExp(`^Round ${round} of ${ROUNDS}\\. An object is hidden`));
    const now = await explored(turns);
    await tab(/^radio/);
    const answers = (await page.locator('#panel').ariaSnapshot()).match(/radio "[^"]+"/g).map((t) => t.slice(7, -1));
    assert.deepEqual([...answers].sort(), [...SHAPES].sort(), 'the answers have names');
    const order = likely(now), mine = order[0]?.[0] ?? SHAPES[0];
    await choose();
    for (let k = 0; k < answers.length && !(await focused()).endsWith(mine); ++k) await press('ArrowDown');
    await tab(/^button Guess/);
    since = heard.length;
    await press('Enter');
    const words = await hears(/(Right|Wrong): it (is|was) /, since, 20000);
    assert.ok(words, `the answer to a guess is not said; the last words: ${heard.slice(-6).join(' | ')}`);
    const truth = /it (?:is|was) (.*)\.$/.exec(words)[1];
    out.push([truth, mine]);
    const next = order.find(([name]) => name !== mine);
    if (next) margins.push(`${mine} ${order[0][1].toFixed(1)} before ${next[0]} ${next[1].toFixed(1)}`);
    if (turns === 0) known.push([truth, now]);
    assert.match(await focused(), /^button (Next round|Result)/);
    since = heard.length;
    await press('Enter');
  }
  return out;
};

/// Saves the results by keys and compares them with what was said; their rows, by the names of columns.
const saved = async (said) => {
  await tab(/^button Save results/);
  const [download] = await Promise.all([page.waitForEvent('download'), press('Enter')]), file = path.join(folder, 'recognition.csv');
  await download.saveAs(file);
  const [head, ...rows] = fs.readFileSync(file, 'utf8').trim().split('\n').map((l) => l.split(','));
  const table = rows.map((r) => Object.fromEntries(head.map((name, k) => [name, r[k]])));
  assert.deepEqual(table.map((r) => [r.object, r.guess]), said);
  return table;
};

if (ORCA) test('a counted game through a screen reader, from its start to the file of results', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  await tab(/^tab Look/);
  await press('ArrowRight');
  const since = heard.length, said = await game('P2', 0), right = said.filter(([object, mine]) => object === mine).length;
  console.log(`      spoken: ${said.map(([object, mine]) => `${object} ${object === mine ? 'named' : `taken for ${mine}`}`).join(', ')}`);
  assert.ok(await hears(new RegExp(`^${right} of ${ROUNDS} right in`), since), 'the score');
  assert.ok(heard.some((t) => /[\d.]+ newtons, pushes /.test(t)), 'forces are spoken');
  assert.ok((await saved(said)).some((r) => Number(r.touched_seconds) > 0));
});

if (!ORCA) test('a counted game by keys and words alone: 4 of 5 objects are named, and the results are a file', async () => {
  await game('P0', 0);
  assert.ok(await hears(/of 6 right/, 0), 'the score of the first game');
  await tab(/^button Other settings/);
  await press('Enter');
  margins.length = 0;
  const since = heard.length, said = await game('P3', 1), first = new Map();
  for (const [object, mine] of said) if (!first.has(object)) first.set(object, mine);
  console.log(`      heard alone: ${said.map(([object, mine]) => `${object} ${object === mine ? 'named' : `taken for ${mine}`}`).join(', ')}`);
  console.log(`      how far apart: ${margins.join(', ')}`);
  assert.equal(first.size, 5);
  const right = [...first].filter(([object, mine]) => object === mine).length;
  assert.ok(right >= 4, `${right} of 5`);
  assert.match(await hears(/of 6 right/, since), new RegExp(`^${said.filter(([object, mine]) => object === mine).length} of 6 right in`));
  assert.ok((await saved(said)).filter((r) => Number(r.touched_seconds) > 0).length >= 4);  // a ring may be known by what is not there
});

if (!ORCA) test('a part that was touched before is said to be known', async () => {
  assert.ok(heard.some((t) => /, new, /.test(t)) && heard.some((t) => /, touched before/.test(t)));
  assert.ok(heard.some((t) => /pushes (up|down|left|right|towards you|away from you)/.test(t)));
  assert.ok(heard.some((t) => /^Touching nothing\. .*The surface is \d+ millimetres? away/.test(t)));
});

if (!ORCA) test('sound follows the position: left and right by the pan, height by the pitch', async () => {
  await page.evaluate(() => {
    window.tones = [];
    const stop = OscillatorNode.prototype.stop, ramp = AudioParam.prototype.setTargetAtTime;
    OscillatorNode.prototype.stop = function (at) { window.tones.push(this.frequency.value); stop.call(this, at); };
    AudioParam.prototype.setTargetAtTime = function (x, at, by) { if (this.minValue === -1 && this.maxValue === 1) window.pan = x; return ramp.call(this, x, at, by); };
  });
  await page.evaluate(() => document.activeElement?.blur());
  await tab(/^tab Recognise/);
  await press('ArrowLeft', 2);
  await page.evaluate((i) => { window.sqmap.world.frame(i); window.sqmap.hand.only = i; }, SHAPES.indexOf('sphere'));
  if (!(await page.isChecked('#panel #sound'))) await page.click('#sound-button');
  await page.focus('#stage');
  await press('Enter');
  const at = async (key, times) => {
    await page.evaluate(() => { window.tones.length = 0; });
    await press(key, times);
    await until(page, () => window.tones.length > 0 && window.sqmap.frame().contacts > 0);
    await page.waitForTimeout(800);
    return page.evaluate(() => ({ tone: window.tones.at(-1), pan: window.pan }));
  };
  const up = await at('ArrowUp', 16), down = await at('ArrowDown', 32), right = await at('ArrowRight', 16), left = await at('ArrowLeft', 32);
  assert.ok(up.tone > 1.3 * down.tone, `${up.tone} Hz above, ${down.tone} Hz below`);
  assert.ok(right.pan > 0.25 && left.pan < -0.25, `${left.pan} to ${right.pan}`);
  await press('Enter');
});

await run(() => page);
