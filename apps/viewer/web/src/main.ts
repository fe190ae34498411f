import './style.css';
import * as THREE from 'three';
import { Charts } from './charts';
import { css, partColour, type Scale } from './colours';
import { Costume } from './costume';
import { announce, bytes, digits, fill, h, save } from './dom';
import { Hand } from './hand';
import { MapView } from './map';
import { meter } from './meter';
import { address, fetchBytes, Link, upload, type Frame, type ObjectFacts, type Settings, type Status } from './net';
import { Recognise } from './recognise';
import { readAgain, Recorder } from './recorder';
import { Rumble, Sound, Voice } from './senses';
import { World, type Hit } from './world';

type Mode = 'look' | 'touch' | 'recognise' | 'dress';
const MODES: Mode[] = ['look', 'touch', 'recognise', 'dress'];

// ---- What there is

let mode: Mode = 'look';
let facts: ObjectFacts[] = [];
let status: Status | null = null;
let selected: { object: number; part: number } | null = null;
let lastFrame: Frame | null = null;
let frames = 0;
let first = true;

const canvas = h('canvas', { id: 'stage', tabIndex: 0, role: 'application', 'aria-label': 'The scene. To look: arrow keys turn it, plus and minus bring it nearer and farther, Home shows all, Enter tells what is in the middle. To touch: arrow keys move the tool, Enter touches and lifts, Page Down presses harder, Q and E walk round, N says what is touched, Space stops. To dress: arrow keys move a cross, Enter takes cloth and lets go, P pins, C begins a cut and ends it.' });
const hint = h('p', { class: 'hint', id: 'hint' });
const legend = h('div', { class: 'legend', hidden: true });
const forceRead = h('output', { class: 'force', id: 'force', 'aria-live': 'off' });
const factsLine = h('p', { class: 'facts-line', id: 'model-facts' });  // always in sight, however the panel is scrolled
const stage = h('div', { class: 'stage' }, canvas, hint, legend, h('div', { class: 'corner' }, forceRead, factsLine));
const world = new World(canvas);
const hand = new Hand(world, canvas);
const charts = new Charts();
const map = new MapView();
const game = new Recognise();
const recorder = new Recorder();
const costume = new Costume(world, canvas, (message) => link.say(message));
const sound = new Sound(), rumble = new Rumble(), voice = new Voice();

// ---- Header

const connection = h('span', { class: 'pill', id: 'connection', role: 'status' }, 'connecting …');
const tabs: Record<Mode, HTMLButtonElement> = { look: tab('look', 'Look'), touch: tab('touch', 'Touch'), recognise: tab('recognise', 'Recognise'), dress: tab('dress', 'Dress') };
function tab(which: Mode, text: string): HTMLButtonElement {
  return h('button', { role: 'tab', id: `tab-${which}`, 'aria-controls': 'panel', onclick: () => setMode(which) }, text);
}
const tabList = h('div', { class: 'tabs', role: 'tablist', 'aria-label': 'What to do', onkeydown: (e: Event) => {
  const order = MODES.filter((m) => !tabs[m].hidden), key = (e as KeyboardEvent).key;
  const by = key === 'ArrowRight' ? 1 : key === 'ArrowLeft' ? -1 : 0;
  if (!by) return;
  const next = order[(order.indexOf(mode) + by + order.length) % order.length];
  setMode(next);
  tabs[next].focus();
} }, ...Object.values(tabs));
const stopButton = h('button', { class: 'stop', id: 'stop', onclick: () => stop() }, h('span', {}, 'STOP'), h('kbd', {}, 'Space'));
const dark = matchMedia('(prefers-color-scheme: dark)'), contrast = matchMedia('(prefers-contrast: more)');
const THEMES = ['light', 'dark', 'contrast'], THEME_NAMES: Record<string, string> = { light: 'Light', dark: 'Dark', contrast: 'High contrast' };
const themeNow = (): string => document.documentElement.dataset.theme ?? (contrast.matches ? 'contrast' : dark.matches ? 'dark' : 'light');
const themeButton = h('button', { class: 'quiet', id: 'theme', title: 'Light, dark, high contrast', onclick: () => {
  setTheme(THEMES[(THEMES.indexOf(themeNow()) + 1) % THEMES.length]);
  announce(`${THEME_NAMES[themeNow()]}.`);
} }, '◐');
function setTheme(name: string): void {
  document.documentElement.dataset.theme = name;
  theme();
}
for (const m of [dark, contrast]) m.addEventListener('change', theme);
function theme(): void {
  if (contrast.matches && !document.documentElement.dataset.theme) document.documentElement.dataset.theme = 'contrast';
  themeButton.setAttribute('aria-label', `Colours: ${THEME_NAMES[themeNow()]}`);
  world.theme();
  charts.theme();
}

// ---- Panel

const panel = h('aside', { class: 'panel', id: 'panel', role: 'tabpanel' });
const notice = h('div', { class: 'notice', id: 'notice', hidden: true });
const dialog = h('section', { class: 'card verdict', id: 'verdict', hidden: true, tabIndex: -1, 'aria-label': 'Verdict on the file' });
const progressBar = h('progress', { max: 1, value: 0, 'aria-label': 'Baking' });
const progressText = h('span', {});
const progressBox = h('div', { class: 'progress', id: 'progress', hidden: true }, progressText, progressBar);
const factsBox = h('div', { class: 'facts', id: 'facts' });
const partBox = h('div', { id: 'part' });
const numbers = h('dl', { class: 'numbers', id: 'numbers' });

function card(title: string, ...children: (Node | string | false)[]): HTMLElement { return h('section', { class: 'card' }, h('h2', {}, title), ...children); }
function choice<T extends string>(label: string, values: [T, string][], value: T, change: (v: T) => void, id: string): HTMLElement {
  const select = h('select', { id, onchange: (e: Event) => change((e.target as HTMLSelectElement).value as T) }, ...values.map(([v, text]) => h('option', { value: v }, text)));
  select.value = value;
  return h('label', { class: 'field' }, h('span', {}, label), select);
}
function check(label: string, on: boolean, change: (on: boolean) => void, id: string): HTMLElement {
  return h('label', { class: 'check' }, h('input', { type: 'checkbox', checked: on, id, onchange: (e: Event) => change((e.target as HTMLInputElement).checked) }), h('span', {}, label));
}

const fileInput = h('input', { type: 'file', id: 'file', class: 'sr-only', accept: '.off,.obj,.stl,.ply,.gltf,.glb,.sqmap,.json', onchange: () => { const f = fileInput.files?.[0]; if (f) void drop(f); fileInput.value = ''; } });

const lookPanel = h('div', {},
  card('Show',
    choice('Colour by', [['parts', 'Parts'], ['error', 'Depth error'], ['protrusion', 'Protrusion'], ['curvature', 'Curvature']], 'parts', (v) => { world.colourBy = v; void world.paint(); }, 'colour'),
    choice('Surface', [['solid', 'Solid'], ['clear', 'See-through'], ['off', 'Hidden']], 'solid', (v) => { world.surfaceAs = v as 'solid'; void world.paint(); }, 'surface'),
    h('div', { class: 'checks', role: 'group', 'aria-label': 'Drawn as well' },
      check('Superquadrics', false, (on) => { world.withSuperquadrics = on; void world.paint(); }, 'superquadrics'),
      check('Spheres', false, (on) => { world.withSpheres = on; void world.paint(); }, 'spheres'),
      check('Map samples', false, (on) => { world.withSamples = on; void world.paint(); }, 'samples'),
      check('Offset (eq. 12)', false, (on) => { world.withOffset = on; void world.paint(); }, 'offset'),
      check('Hidden (Q2)', false, (on) => { world.withHidden = on; void world.paint(); }, 'hidden'))),
  card('Place and part', numbers, partBox));
const mapCard = card('Map of the part', map.element);

let settings: Settings = { layer: 'auto', stiffness: 400, damping: 0.3, friction: 0.3, texture: 0, smoothing: 0, toolRadius: 0.006, zone: 0, forceLimit: 2, tool: 'ball', toolSize: 0.06, toolTurn: 0, toolTilt: 0 };
const sliders: { set(): void }[] = [];
function slider(label: string, unit: string, range: [number, number, number], get: () => number, set: (x: number) => void, live = true): HTMLElement {
  const id = `s-${label.toLowerCase().replace(/[^a-z]+/g, '-')}`;
  const read = h('output', { for: id }), input = h('input', { type: 'range', id, min: String(range[0]), max: String(range[1]), step: String(range[2]) });
  const show = () => { read.textContent = `${digits(Number(input.value), 4)} ${unit}`; input.setAttribute('aria-valuetext', read.textContent); };
  input.addEventListener('input', () => { show(); if (live) { set(Number(input.value)); tellSettings(); } });
  input.addEventListener('change', () => { if (!live) { set(Number(input.value)); tellSettings(); } });
  sliders.push({ set: () => { if (document.activeElement !== input) { input.value = String(get()); } show(); } });
  return h('label', { class: 'field slider' }, h('span', {}, label), input, read);
}
const layerChoice = choice('Layer', [['auto', 'As the tool needs'], ['2', '2: base map'], ['3', '3: refined map'], ['exact', 'Exact triangles']], 'auto', (v) => { settings.layer = v; tellSettings(); }, 'layer');
const toolSelect = h('select', { id: 'tool', onchange: () => { const v = toolSelect.value; settings.tool = v === 'ball' || v === 'hand' ? v : Number(v); hand.letGo(); tellSettings(); showToolRows(); } });
const deviceSelect = h('select', { id: 'device', onchange: () => link.say({ say: 'device', device: Number(deviceSelect.value) }) });
const deviceTable = h('tbody', { id: 'devices' });
const deviceFacts = h('p', { class: 'note', id: 'device-facts' });
const counters = h('p', { class: 'note', id: 'counters' }), pageCost = h('p', { class: 'note', id: 'page-cost' });
const pressRead = slider('Press', 'mm', [-2, 12, 0.5], () => 1000 * hand.press, (x) => { hand.press = x / 1000; hand.deeper(0); });
const ballRows = [slider('Tool radius', 'mm', [2, 20, 0.5], () => 1000 * settings.toolRadius, (x) => { settings.toolRadius = x / 1000; }, false),
  slider('Smoothing', 'mm', [0, 5, 0.25], () => 1000 * settings.smoothing, (x) => { settings.smoothing = x / 1000; }, false)];
const meshRows = [slider('Tool size', 'mm', [10, 300, 5], () => 1000 * settings.toolSize, (x) => { settings.toolSize = x / 1000; }, false),
  slider('Turn', '°', [-180, 180, 15], () => settings.toolTurn, (x) => { settings.toolTurn = x; }, false),
  slider('Tilt', '°', [-180, 180, 15], () => settings.toolTilt, (x) => { settings.toolTilt = x; }, false)];
function showToolRows(): void {
  for (const r of ballRows) r.hidden = settings.tool !== 'ball';
  for (const r of meshRows) r.hidden = settings.tool === 'ball';
}
function showTools(): void {
  fill(toolSelect, h('option', { value: 'ball' }, 'Ball'), h('option', { value: 'hand' }, 'Hand'), ...facts.map((f, i) => f.hasTriangles ? h('option', { value: String(i) }, `${f.name} (of the scene)`) : null));
  toolSelect.value = String(settings.tool);
  showToolRows();
}

let toolShown = -1;
async function fetchTool(revision: number): Promise<void> {
  if (revision === toolShown) return;
  toolShown = revision;
  const held = typeof settings.tool === 'number' ? settings.tool : -1;
  if (world.inHand !== held) { world.inHand = held; void world.paint(); }
  if (settings.tool === 'ball') { world.toolShape(null, null); return; }
  try {
    const data = await fetchBytes('/api/tool'), [, v, t] = new Uint32Array(data, 0, 3);
    if (revision === toolShown) world.toolShape(new Float32Array(data, 12, 3 * v), new Uint32Array(data, 12 + 12 * v, 3 * t));
  } catch (e) { toolShown = -1; trouble(String(e)); }
}

// ---- Recordings

const recordButton = h('button', { id: 'record', onclick: () => {
  if (recorder.recording) endRecording(); else { recorder.halt(); recorder.start(); againWords.textContent = ''; link.say({ say: 'record', on: true }); }
  showRecorder();
} });
const replayButton = h('button', { id: 'replay', onclick: () => {
  if (recorder.replaying) recorder.halt();
  else { hand.letGo(); charts.clear(); recorder.replay(); }
  showRecorder();
} });
const saveButton = h('button', { id: 'save-recording', onclick: () => save('touch.csv', recorder.csv(), 'text/csv') }, 'Save');
const recordingInput = h('input', { type: 'file', id: 'recording-file', class: 'sr-only', accept: '.csv', onchange: async () => {
  const f = recordingInput.files?.[0];
  if (f) try { recorder.open(await f.text()); wait(`${f.name}: ${recorder.seconds.toFixed(1)} s, ready to replay.`); } catch (e) { trouble(`${f.name}: ${e instanceof Error ? e.message : e}`); }
  recordingInput.value = '';
  showRecorder();
} });
const recordingWords = h('p', { class: 'note', id: 'recording' }), againWords = h('p', { id: 'again-words', role: 'status' });
function endRecording(): void { recorder.stop(); link.say({ say: 'record', on: false }); }
recorder.onFull = () => { endRecording(); showRecorder(); };
const againButton = h('button', { id: 'again', onclick: () => void computeAgain() }, 'Compute again');

/// First with all as it was: that must give the same bits. Then with the objects and settings of now.
async function computeAgain(): Promise<void> {
  againButton.disabled = true;
  againWords.textContent = 'Computing every tick again …';
  try {
    const then = readAgain(await fetchBytes('/api/again/then')), now = readAgain(await fetchBytes('/api/again/now')), ticks = then.ticks.length / 3;
    recorder.again = now;
    const n = ticks.toLocaleString('en');
    const proof = then.different === 0 ? `✓ ${n} ticks, computed again: every force is the same to the bit.` :
      `✗ ${n} ticks, computed again: ${then.different.toLocaleString('en')} differ, by at most ${digits(then.largestForce)} N.${then.lost ? ` ${then.lost} ticks were lost while recording: what has a memory may differ after them.` : ''}`;
    const change = now.different === 0 ? 'With the objects and settings of now: the same.' :
      `With the objects and settings of now the force differs by at most ${digits(now.largestForce)} N (root mean square ${digits(now.rmsForce)} N), the depth by ${digits(1000 * now.largestDepth)} mm.`;
    againWords.textContent = `${proof} ${change} Replay draws it dashed, before the safety filter.`;
  } catch (e) { againWords.textContent = ''; trouble(String(e)); }
  showRecorder();
}
function showRecorder(at = 0): void {
  recordButton.textContent = recorder.recording ? 'Stop recording' : 'Record';
  recordButton.setAttribute('aria-pressed', String(recorder.recording));
  replayButton.textContent = recorder.replaying ? 'Stop replay' : 'Replay';
  replayButton.disabled = saveButton.disabled = recorder.count === 0 || recorder.recording;
  againButton.disabled = !recorder.known || recorder.recording;
  recordingWords.textContent = recorder.recording ? 'Recording every tick …' : recorder.replaying ? `Replaying: ${at.toFixed(1)} of ${recorder.seconds.toFixed(1)} s` :
    recorder.count ? `${recorder.seconds.toFixed(1)} s ${recorder.known ? 'recorded' : 'opened: the poses of every tick stay with the program that felt them, so it cannot be computed again'}.` : 'Nothing recorded yet.';
}
recorder.onFrame = (frame, at) => { show(frame); draw(frame); showRecorder(at); };
recorder.onEnd = () => { hideTool(); sound.quiet(); showRecorder(); };

const touchPanel = h('div', {},
  card('Feel', pressRead,
    slider('Stiffness', 'N/m', [50, 1500, 10], () => settings.stiffness, (x) => { settings.stiffness = x; }),
    slider('Friction', '', [0, 1, 0.05], () => settings.friction, (x) => { settings.friction = x; }),
    slider('Texture', 'mm', [0, 0.6, 0.05], () => 1000 * settings.texture, (x) => { settings.texture = x / 1000; }, false),
    slider('Damping', 'N s/m', [0, 2, 0.1], () => settings.damping, (x) => { settings.damping = x; }),
    layerChoice),
  card('Tool', h('label', { class: 'field' }, h('span', {}, 'Tool'), toolSelect), ...ballRows, ...meshRows,
    slider('Impact zone', 'mm', [0, 40, 1], () => 1000 * settings.zone, (x) => { settings.zone = x / 1000; }, false),
    slider('Force limit', 'N', [0.2, 3.2, 0.1], () => settings.forceLimit, (x) => { settings.forceLimit = x; }, false),
    h('p', { class: 'note' }, 'Smoothing above 0 makes the ball a point that feels with a sphere of that radius. An impact zone of 0 is the whole tool; a ball has none. A mesh is felt by its corners; one of the scene is not there to be touched while you hold it.')),
  card('Recording', h('div', { class: 'row wrap' }, recordButton, replayButton, againButton, saveButton, h('button', { onclick: () => recordingInput.click() }, 'Open …'), recordingInput), recordingWords, againWords),
  card('Device', h('label', { class: 'field' }, h('span', {}, 'Device'), deviceSelect), deviceFacts,
    h('details', { id: 'device-list' }, h('summary', {}, 'All devices'), h('table', {}, h('thead', {}, h('tr', {}, ...['Device', 'State', 'Rate', 'Limit'].map((t) => h('th', { scope: 'col' }, t)))), deviceTable))),
  card('Other senses', h('div', { class: 'senses' })));

/// One set of switches, in whichever panel is shown.
const senses = h('div', {},
  check('Force as sound', false, (on) => { if (on) sound.start(); else sound.stop(); }, 'sound'),
  check('Say the touched part', false, (on) => { voice.on = on; voice.forget(); }, 'voice'),
  check('Rumble of a game pad', true, (on) => { rumble.on = on; }, 'rumble'),
  h('p', { class: 'note', id: 'pads' }),
  h('p', { class: 'note' }, 'On the stage, N says the touched part and the force.'));
function showPads(): void { senses.querySelector('#pads')!.textContent = rumble.available() ? 'A game pad that rumbles is here.' : 'No game pad that rumbles was found: press one of its buttons.'; }
for (const type of ['gamepadconnected', 'gamepaddisconnected']) addEventListener(type, showPads);
showPads();

const gamePanel = h('div', {}, card('Recognise by touch', game.element), card('Senses', h('p', { class: 'note' }, 'Sound and spoken parts start with the game.'), h('div', { class: 'senses' })));

const sharePanel = card('Files', h('div', { class: 'row wrap' },
  h('button', { id: 'open', onclick: () => fileInput.click() }, 'Open a mesh …'), fileInput,
  h('button', { id: 'picture', onclick: async () => { const b = await world.picture(); if (b) save('sqmap.png', b, 'image/png'); } }, 'Picture'),
  h('button', { id: 'link', onclick: () => copyLink() }, 'Copy link')),
  h('div', { class: 'row wrap', id: 'exports' }));

const dressPanel = h('div', {}, card('Costume', costume.element));

panel.append(notice, progressBox, dialog, mapCard, factsBox, h('div', { id: 'mode-panel' }), card('Timing', counters, pageCost), sharePanel);

const main = h('main', {}, stage, panel, charts.element);
document.getElementById('app')!.replaceChildren(
  h('header', {}, h('h1', {}, 'sqmap'), tabList, connection, themeButton, stopButton), main,
  h('div', { class: 'dropzone', id: 'dropzone', hidden: true }, h('strong', {}, 'Drop the mesh: it is checked, then baked')));

// ---- Modes

const HIDDEN_HINT = 'Drag over this empty stage, or use the arrow keys: the object is here, unseen.';
const hints: Record<Mode, string> = {
  look: 'Drag to turn it. Click it for numbers. Drop a mesh here to bake it.',
  touch: 'Press on an object and drag: you are touching it. The arrow is the force.',
  recognise: 'Press Begin, then feel for the hidden object with sound on.',
  dress: 'The figure is being prepared: some seconds.',
};

function setMode(next: Mode): void {
  hand.letGo();
  recorder.halt();
  if (mode !== next) { dialog.hidden = true; panel.scrollTop = 0; }
  const before = mode;
  mode = next;
  for (const [m, b] of Object.entries(tabs)) { b.setAttribute('aria-selected', String(m === mode)); b.tabIndex = m === mode ? 0 : -1; }
  document.getElementById('mode-panel')!.replaceChildren(mode === 'look' ? lookPanel : mode === 'touch' ? touchPanel : mode === 'dress' ? dressPanel : gamePanel);
  panel.querySelector('.senses')?.append(senses);
  panel.setAttribute('aria-labelledby', `tab-${mode}`);
  main.dataset.mode = mode;
  hint.textContent = game.running && mode !== 'dress' ? (mode === 'recognise' ? HIDDEN_HINT : 'A round of recognition goes on: the objects stay hidden until you leave the game.') : hints[mode];
  hint.hidden = false;
  hand.enabled = mode === 'touch' || mode === 'recognise';
  if (mode !== 'recognise') hand.only = game.running ? hand.only : -1;
  world.hidden = mode === 'dress' || game.running;
  canvas.classList.toggle('touching', hand.enabled);
  factsBox.hidden = mode === 'recognise' || mode === 'dress';
  showMapCard();
  showFactsLine();
  showStopped();
  if (before !== mode && mode === 'dress') { world.mark(null); if (costume.last) hint.hidden = true; costume.enter(); }
  if (before === 'dress' && mode !== 'dress') { costume.leave(); world.mark(null); world.frame(); }
  if (mode === 'look' || mode === 'dress') hideTool();
  world.dims = mode === 'look';
  void world.paint();
}

// ---- Touch

// The newest aim, at most once a frame of the stream; to grasp and to let go is told at once.
let aim: object | null = null, wasHeld = false;
setInterval(() => { if (aim) link.say(aim); aim = null; }, 16);
hand.onAim = (target, held) => {
  aim = { say: 'touch', p: target.toArray().map((x) => Number(x.toFixed(6))), held };
  if (held !== wasHeld) { link.say(aim); aim = null; }
  wasHeld = held;
  if (held) hint.hidden = true;
  };
/// Asked for, also where nothing has changed.
hand.onAsk = () => {
  const f = lastFrame, name = f && f.contacts > 0 ? touchedName(f) : '';
  voice.answer(!f || f.contacts === 0 ? 'Touching nothing' : `${name}, ${Math.hypot(...f.force).toFixed(1)} newtons`);
};
hand.onKeyTouch = (text) => { announce(text); if (mode === 'touch') sliders.forEach((s) => s.set()); };

function stop(): void {
  link.say({ say: 'stop' });
  recorder.halt();
  hand.letGo();
  costume.release();
  sound.quiet();
  announce('Stopped. No force.', true);
}
function resume(): void { link.say({ say: 'resume' }); announce('Going on.'); canvas.focus(); }

document.addEventListener('keydown', (e) => {
  if (e.code !== 'Space') return;
  const at = document.activeElement;
  // While anything can be felt the space bar is STOP wherever the focus is; else buttons and fields keep it.
  const felt = hand.holding || costume.held || (status?.touching && (status.device > 0 || (lastFrame && lastFrame.contacts > 0)));
  if (!felt && at && at !== document.body && at !== canvas) return;
  e.preventDefault();
  stop();
});
window.addEventListener('blur', () => hand.letGo());

let settingsDue = 0, settingsChanged = -1e9;
function tellSettings(): void {
  settingsChanged = performance.now();
  world.toolRadius(settings.smoothing > 0 ? settings.smoothing : settings.toolRadius);
  clearTimeout(settingsDue);
  settingsDue = window.setTimeout(() => { settingsDue = 0; settingsChanged = performance.now(); link.say({ say: 'settings', ...settings }); }, 40);
}

const REASONS: [number, string][] = [
  [1, 'not a number'], [2, 'no fresh position'], [4, 'easing in'], [8, 'at the force limit'], [16, 'rising gently'],
  [32, 'too fast'], [64, 'damped to stay stable'], [128, 'resting the motors'], [256, 'at the last limit'], [512, 'off'],
];

function onFrame(frame: Frame): void {
  ++frames;
  lastFrame = frame;
  hand.heard(frame.engaged, frame.contacts > 0 && !frame.engaged && frame.faults === 0);
  recorder.add(frame);
  if (recorder.recording) recordingWords.textContent = `Recording every tick: ${recorder.seconds.toFixed(0)} s`;
  if (!recorder.replaying) show(frame);
}

/// A frame of now, or of a recording: heard at once, drawn with the next picture.
let toDraw: Frame | null = null;
function show(frame: Frame): void {
  charts.add(frame, recorder.replaying ? recorder.againOf(frame) : null);
  if (mode === 'look' || mode === 'dress') return;
  toDraw = frame;
  const force = Math.hypot(...frame.force);
  sound.play(frame, world.project(toolPlace.set(...(frame.tool as [number, number, number]))).x);
  rumble.play(force, settings.forceLimit);
  game.feel(frame);
  const name = frame.contacts > 0 ? touchedName(frame) : '';
  voice.touch(mode === 'recognise' && !game.running ? '' : name);
  if (frame.faults & 16 && !recorder.replaying) showResume();
}
const toolPlace = new THREE.Vector3();
const touchedName = (frame: Frame): string => (frame.object >= 0 ? facts[frame.object]?.parts[frame.part]?.name : undefined) ?? 'surface';

function hideTool(): void { toDraw = null; world.showTool(null); forceRead.textContent = ''; }

function draw(frame: Frame): void {
  world.showTool(frame);
  const force = Math.hypot(...frame.force);
  const why = REASONS.filter(([bit]) => (frame.acted & bit) !== 0).map(([, text]) => text);
  const words = !frame.connected ? 'device gone' : frame.faults & 16 ? 'stopped' : frame.faults ? 'no force: the filter found a fault (the computer was busy?). Lift and touch again' :
    frame.contacts > 0 && !frame.engaged && force === 0 ? 'no force yet: lift once, then it comes in gently' :
    frame.contacts > 0 ? `${force.toFixed(2)} N · ${(1000 * frame.depth).toFixed(1)} mm deep · ${game.running ? 'touching' : touchedName(frame)}` : 'free';
  const text = words + (why.length && frame.contacts > 0 ? ` · ${why.join(', ')}` : '');
  if (forceRead.textContent !== text) forceRead.textContent = text;
}

let costDue = 0;
world.onFrame = (now) => {
  if (toDraw) meter.spend('message', () => draw(toDraw as Frame));
  toDraw = null;
  meter.spend('charts', () => charts.frame(now));
  if (now < costDue) return;
  costDue = now + 1000;
  pageCost.textContent = meter.words();
};
voice.onSay = (text) => { if (text && mode !== 'look') announce(text); };

// ---- Facts, parts, numbers

const parts = (n: number): string => (n === 1 ? '1 part' : `${n} parts`);

/// Of the selected object, or of the only one, else of all.
function showFactsLine(): void {
  factsLine.hidden = mode === 'dress' || facts.length === 0;
  const f = game.running ? undefined : facts[selected?.object ?? (facts.length === 1 ? 0 : -1)];
  const all = f ? [f] : facts, certified = all.every((g) => g.parts.every((p) => p.certified));
  const count = parts(all.reduce((n, g) => n + g.parts.length, 0)), worst = Math.max(...all.map((g) => g.measured.depthP99));
  factsLine.textContent = all.some((g) => g.edited) ? `${f ? `${f.name}: ` : `${all.length} models: `}${count}, edited: bake them to know bytes and errors` :
    `${f ? `${f.name}: ` : `${all.length} models: `}${count} · ${bytes(all.reduce((n, g) => n + g.bytes.total, 0))} · ${certified ? '✓ certified to hold the surface' : '✗ not all certified'} · 99 % of depths measured within ${digits(worst, 2)} % of R_max`;
}
function showMapCard(): void { mapCard.hidden = mode !== 'look' || game.running || !selected || selected.part < 0; }

function showFacts(): void {
  showFactsLine();
  showMapCard();
  const rows = facts.map((f, i) => {
    const certified = f.parts.filter((p) => p.certified).length;
    const current = selected?.object === i;
    const title = h('button', { class: 'object', 'aria-pressed': String(current), onclick: () => { select(i, -1); if (mode !== 'recognise') world.frame(i); } }, f.name + (f.edited ? ' (edited, not baked)' : ''));
    const warn = f.measured.missed + f.measured.false > 0;
    return h('li', {}, title,
      h('span', {}, `${parts(f.parts.length)}, ${f.edited ? '' : `${bytes(f.bytes.total)}, `}${f.triangles.toLocaleString('en')} faces`),
      h('span', { class: warn || certified < f.parts.length ? 'warn' : '', title: `Layer 3 on ${f.measured.points} points: ${f.measured.missed} missed, ${f.measured.false} false; depth error median ${digits(f.measured.depthMedian, 2)} %, 99th percentile ${digits(f.measured.depthP99, 2)} % of R_max, the object's largest extent` },
        f.edited ? 'Bytes, certificates and errors are told once the parts are baked.' : `${certified === f.parts.length ? '✓ all certified' : `✗ ${certified} certified`}; 99 % of depths within ${digits(f.measured.depthP99, 2)} %${warn ? `, ✗ ${f.measured.missed + f.measured.false} wrong` : ''}`));
  });
  factsBox.replaceChildren(h('section', { class: 'card' }, h('h2', {}, facts.length === 1 ? 'Model' : `Models (${facts.length})`),
    facts.length ? h('ul', { class: 'objects' }, ...rows) : h('p', {}, 'Nothing is open: drop a mesh, or press Open.')));
  factsBox.hidden = mode === 'recognise' || mode === 'dress';  // they are not about models
}

function select(object: number, part: number): void {
  selected = object < 0 ? null : { object, part };
  world.select(object, part);
  showPart();
  showFacts();
  showExports();
}

let chosenOther = -1, cutStep = 0.004;
const CUT_STEPS: [number, string][] = [[0, 'a row'], [0.002, '2 mm'], [0.004, '4 mm'], [0.01, '10 mm']];

function showPart(): void {
  const s = selected, f = s ? facts[s.object] : undefined;
  if (!s || !f) { partBox.replaceChildren(); map.clear('Select a part: click the object.'); if (!numbers.childElementCount) setNumbers([]); return; }
  const say = (name: string, more: object = {}) => link.say({ say: name, object: s.object, ...more });
  const edits = h('div', { class: 'row wrap', role: 'group', 'aria-label': 'Edit the parts' });
  const p = f.parts[s.part];
  if (p) {
    const neighbours = p.neighbours.length ? p.neighbours : f.parts.map((_, i) => i).filter((i) => i !== s.part);
    const other = h('select', { id: 'other', 'aria-label': 'The other part' }, ...neighbours.map((i) => h('option', { value: String(i) }, f.parts[i].name)));
    if (neighbours.includes(chosenOther)) other.value = String(chosenOther);
    other.addEventListener('change', () => { chosenOther = Number(other.value); });
    const by = h('select', { id: 'by', 'aria-label': 'How far the cut moves' }, ...CUT_STEPS.map(([v, t]) => h('option', { value: String(v) }, t)));
    by.value = String(cutStep);
    by.addEventListener('change', () => { cutStep = Number(by.value); });
    const move = (part: number, into: number) => { chosenOther = Number(other.value); wait('Moving the cut …'); say('movecut', { part, other: into, distance: cutStep }); };
    edits.append(h('button', { id: 'split', onclick: () => { wait('Cutting …'); say('split', { part: s.part }); } }, 'Split'));
    if (f.parts.length > 1) edits.append(h('fieldset', {}, h('legend', {}, 'Its cut with'), other,
      h('div', { class: 'row wrap' }, h('button', { id: 'grow', onclick: () => move(s.part, Number(other.value)) }, 'Push out'), h('button', { id: 'shrink', onclick: () => move(Number(other.value), s.part) }, 'Pull in'), by,
        h('button', { id: 'merge', onclick: () => { wait('Joining …'); say('merge', { part: s.part, other: Number(other.value) }); } }, 'Merge'))));
    edits.append(h('button', { id: 'refit', onclick: () => { wait('Fitting …'); say('refit', { part: s.part }); } }, 'Refit'));
  }
  edits.append(h('button', { id: 'undo', disabled: !f.canUndo, onclick: () => say('undo') }, 'Undo'), h('button', { id: 'redo', disabled: !f.canRedo, onclick: () => say('redo') }, 'Redo'));
  if (f.edited) edits.append(h('button', { id: 'bake', class: 'primary', onclick: () => say('bake') }, 'Bake the edited parts'));
  edits.append(h('button', { id: 'remove', onclick: () => { say('remove'); select(-1, -1); } }, 'Remove object'));
  const name = p && h('input', { type: 'text', id: 'part-name', value: p.name, maxLength: 60, 'aria-label': 'Name of the part', onchange: (e: Event) => say('name', { part: s.part, name: (e.target as HTMLInputElement).value.trim().slice(0, 60) }) });
  const list = h('details', {}, h('summary', {}, `All ${f.parts.length} parts`), h('ol', { class: 'parts', start: 0 }, ...f.parts.map((q, i) =>
    h('li', {}, h('button', { class: 'part', 'aria-pressed': String(i === s.part), onclick: () => select(s.object, i) }, h('i', { style: `background:${css(partColour(i))}`, 'aria-hidden': 'true' }), q.name, q.certified ? '' : ' (not certified)')))));
  fill(partBox,
    name && h('label', { class: 'field' }, h('span', {}, 'Part'), name),
    p && h('p', { class: 'note' }, `${p.triangles.toLocaleString('en')} triangles, ${digits(p.area, 2)} % of the surface; half axes ${p.a.map((x) => digits(1000 * x)).join(' × ')} mm, exponents ${p.eps.map((x) => digits(x, 2)).join(', ')}${p.taper.some((t) => t) ? ', tapered' : ''}${p.bend ? ', bent' : ''}; ${p.certified ? `proven to hold its surface (F ≤ ${digits(p.largestF ?? 0, 4)})` : 'not proven to hold its surface'}`),
    edits, list);
  if (!p) map.clear('Select a part: click the object.');
  else if (f.edited) map.clear('Edited parts have a map once they are baked.');
  else if (!f.central) map.clear('This model holds the paper’s own maps: sqmap render --what map draws them.');
  else map.load(s.object, s.part, p.name).catch((e) => trouble(String(e)));
}

function setNumbers(rows: [string, string][]): void {
  numbers.replaceChildren(...(rows.length ? rows.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)]) : [h('dt', { class: 'whole' }, 'Click the object for its numbers.')]));
}

async function click(hit: Hit | null): Promise<void> {
  if (game.running) return;  // what is hidden is not told
  panel.scrollTop = 0;
  if (!hit) { select(-1, -1); world.mark(null); setNumbers([]); return; }
  world.mark(hit.point);
  const f = facts[hit.object];
  select(hit.object, hit.part);
  const mm = (v: THREE.Vector3) => v.toArray().map((x) => (1000 * x).toFixed(1)).join(', ');
  const error = world.fieldAt(hit.object, 'error', hit.triangle);
  const rows: [string, string][] = [['Object', f.name], ['Part', `${hit.part}: ${f.parts[hit.part].name}`], ['Triangle', String(hit.triangle)], ['Point', `${mm(hit.point)} mm`],
    ['Normal', hit.normal.toArray().map((x) => x.toFixed(2)).join(', ')]];
  if (error !== undefined) rows.push(['Depth error', error === -1 ? 'missed' : error < 0 ? 'too thin to say' : `${digits(error)} % of R_max`]);
  for (const kind of ['protrusion', 'curvature']) { const v = world.fieldAt(hit.object, kind, hit.triangle); if (v !== undefined) rows.push([kind[0].toUpperCase() + kind.slice(1), digits(v)]); }
  setNumbers(rows);
  announce(rows.slice(0, 2).map((r) => r[1]).join(', '));
}

let pressed: { x: number; y: number } | null = null;
const ndc = (e: PointerEvent): [number, number] => { const b = canvas.getBoundingClientRect(); return [(2 * (e.clientX - b.left)) / b.width - 1, 1 - (2 * (e.clientY - b.top)) / b.height]; };
canvas.addEventListener('pointerdown', (e) => { pressed = { x: e.clientX, y: e.clientY }; if (mode === 'look') hint.hidden = true; });
canvas.addEventListener('pointerup', (e) => {
  if (mode === 'look' && pressed && Math.hypot(e.clientX - pressed.x, e.clientY - pressed.y) < 4) void click(world.cast(...ndc(e)));
  pressed = null;
});
canvas.addEventListener('pointermove', (e) => {
  if (mode !== 'look' || pressed || !selected || facts[selected.object]?.edited) return;
  const hit = world.cast(...ndc(e));
  if (hit && hit.object === selected.object && hit.part === selected.part) { map.show(hit.point); world.mark(hit.point); }
});
document.addEventListener('keydown', (e) => {
  if (mode !== 'look' || !selected || !(e.ctrlKey || e.metaKey) || e.key.toLowerCase() !== 'z' || document.activeElement instanceof HTMLInputElement) return;
  const f = facts[selected.object];
  if (!(e.shiftKey ? f?.canRedo : f?.canUndo)) return;
  e.preventDefault();
  link.say({ say: e.shiftKey ? 'redo' : 'undo', object: selected.object });
});
// The same without a pointer.
canvas.addEventListener('keydown', (e) => {
  if (mode !== 'look' || e.ctrlKey || e.altKey || e.metaKey) return;
  const step = e.shiftKey ? Math.PI / 90 : Math.PI / 24;
  const turns: Record<string, [number, number]> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
  if (turns[e.key]) world.turn(...turns[e.key]);
  else if (e.key === '+' || e.key === '=') world.zoom(0.87);
  else if (e.key === '-') world.zoom(1.15);
  else if (e.key === 'Home') world.frame();
  else if (e.key === 'Enter') {
    const hit = world.cast(0, 0);
    if (!hit) announce('Nothing in the middle of the view.');
    void click(hit);
  } else return;
  e.preventDefault();
  hint.hidden = true;
});
map.onPoint = (p) => world.mark(p);
map.onPick = (p) => { if (selected) void click(world.nearest(selected.object, p)); };

// ---- Files

function showExports(): void {
  const i = selected?.object ?? 0, f = facts[i];
  document.getElementById('exports')!.replaceChildren(...(f ? [
    h('span', { class: 'note' }, `Save ${f.name} as`),
    ...(['glb', 'json', 'sqmap'] as const).map((kind) => kind === 'sqmap' && f.edited ? h('button', { id: 'save-sqmap', onclick: () => trouble('Bake the edited parts first: the model file would hold the parts of before.') }, 'Model') : h('a', { class: 'button', id: `save-${kind}`, href: address(`/api/object/${i}/${kind}`), download: `${f.name}.${kind}` }, kind === 'glb' ? 'GLB' : kind === 'json' ? 'JSON' : 'Model')),
    h('a', { class: 'button', id: 'save-names', href: address(`/api/object/${i}/names`), download: `${f.name}.names.json` }, 'Names')] : []));
}

async function drop(file: File, repair: '' | 'holes' | 'surface' = ''): Promise<void> {
  dialog.hidden = false;
  dialog.className = 'card verdict';
  dialog.replaceChildren(h('h2', {}, file.name), h('p', {}, 'Checking …'));
  try {
    const v = await upload(file, repair, (share) => { dialog.lastElementChild!.textContent = share < 1 ? `Sending ${Math.round(100 * share)} %` : 'Checking …'; });
    const good = v.accepted;
    dialog.className = `card verdict ${good ? 'good' : 'bad'}`;
    fill(dialog, h('h2', {}, file.name), h('p', { class: 'word' }, `${good ? '✓' : '✗'} ${v.verdict}${v.code ? ` ${v.code}` : ''}`),
      v.message && h('p', {}, `${v.element ? `At ${v.element}: ` : ''}${v.message}`), v.cure && h('p', {}, `What helps: ${v.cure}`),
      v.notes?.length ? h('ul', {}, ...v.notes.map((n) => h('li', {}, n))) : null,
      v.code === 'E_OPEN' && repair !== 'holes' && h('button', { class: 'primary', id: 'holes', onclick: () => void drop(file, 'holes') }, 'Try again with small holes filled'), ' ',
      (v.code === 'E_OPEN' || v.code === 'E_FLAT') && repair !== 'surface' && h('button', { id: 'as-surface', onclick: () => void drop(file, 'surface') }, 'Take it as a surface without inside'), ' ',
      h('button', { onclick: () => { dialog.hidden = true; } }, 'Close'));
    announce(`${file.name}: ${v.verdict}. ${v.message ?? ''}`, !good);
    if (!good) dialog.focus();
  } catch (e) { dialog.hidden = true; trouble(`${file.name}: ${e instanceof Error ? e.message : e}`); }
}
const zone = document.getElementById('dropzone')!;
addEventListener('dragover', (e) => { e.preventDefault(); zone.hidden = false; });
addEventListener('dragleave', (e) => { if (!e.relatedTarget) zone.hidden = true; });
addEventListener('drop', (e) => { e.preventDefault(); zone.hidden = true; const f = e.dataTransfer?.files[0]; if (f) void drop(f); });

const OVERLAYS = ['spheres', 'samples', 'offset', 'hidden'];
function copyLink(): void {
  const view = { m: mode, c: world.pose(), k: world.colourBy, s: world.surfaceAs, q: world.withSuperquadrics, o: OVERLAYS.filter((id) => lookPanel.querySelector<HTMLInputElement>(`#${id}`)!.checked), t: document.documentElement.dataset.theme, p: selected,
    f: mode === 'touch' ? settings : undefined, w: mode === 'dress' ? costume.chosen() : undefined };
  location.hash = `view=${encodeURIComponent(JSON.stringify(view))}`;
  const done = () => announce('The link is in the address bar and the clipboard. It holds as long as the program runs.');
  navigator.clipboard?.writeText(location.href).then(done, done);
  wait('Link copied: it restores this view as long as the program runs.');
}
function restoreLink(): void {
  const text = new URLSearchParams(location.hash.slice(1)).get('view');
  if (!text) return;
  try {
    const v = JSON.parse(text);
    const set = (id: string, value: unknown) => { const e = lookPanel.querySelector<HTMLSelectElement & HTMLInputElement>(`#${id}`)!; if (typeof value === 'boolean') e.checked = value; else e.value = String(value); e.dispatchEvent(new Event('change')); };
    set('colour', v.k); set('surface', v.s); set('superquadrics', Boolean(v.q));
    for (const id of OVERLAYS) set(id, Array.isArray(v.o) && v.o.includes(id));
    if (THEMES.includes(v.t)) setTheme(v.t);
    if (v.f) {
      for (const k of Object.keys(settings) as (keyof Settings)[]) if (typeof v.f[k] === typeof settings[k] || k === 'tool') settings = { ...settings, [k]: v.f[k] };
      tellSettings();
    }
    if (Array.isArray(v.w)) costume.choose(v.w);
    if (MODES.includes(v.m) && !tabs[v.m as Mode].hidden) setMode(v.m);
    world.setPose(v.c);
    if (v.p && facts[v.p.object]) select(v.p.object, v.p.part);
  } catch { /* a link that somebody has changed: the view stays as it is */ }
}

// ---- Notices

let noticeDue = 0;
function wait(text: string): void {
  notice.hidden = false;
  notice.className = 'notice';
  notice.textContent = text;
  clearTimeout(noticeDue);
  noticeDue = window.setTimeout(() => { notice.hidden = true; }, 5000);
}
function trouble(text: string): void { wait(text); notice.className = 'notice bad'; announce(text, true); }
function showResume(text = 'Stopped: there is no force.'): void {
  if (stage.querySelector('#resume')) return;
  stage.append(h('div', { class: 'stopped', role: 'alertdialog', 'aria-label': text }, h('p', {}, text), h('button', { id: 'resume', class: 'primary', onclick: () => resume() }, 'Resume')));
}
function hideResume(): void { stage.querySelector('.stopped')?.remove(); }
/// Where nothing is felt it is in nobody's way.
function showStopped(): void { if (status?.stopped && (mode === 'touch' || mode === 'recognise')) showResume(); else hideResume(); }
world.onTrouble = trouble;
world.onWait = (kind, done, of) => {
  const names: Record<string, string> = { error: 'depth error', protrusion: 'protrusion', curvature: 'curvature' };
  legend.hidden = false;
  fill(legend, h('span', { id: 'waiting' }, `Computing the ${names[kind] ?? kind}: ${done} of ${of} objects …`), h('progress', { max: of, value: done, 'aria-label': 'Computing' }));
};
world.onScale = (scale: Scale | null) => {
  const q2 = world.hiddenShare.length ? h('span', { class: 'note', id: 'q2' }, `Magenta: hidden from its part's projection (Q2), of the surface: ${world.hiddenShare.join(', ')}`) : '';
  legend.hidden = !scale && !q2;
  if (!scale) { fill(legend, q2); return; }
  const stops = Array.from({ length: 9 }, (_, i) => css(scale.colour(i / 8))).join(',');
  legend.replaceChildren(h('span', {}, scale.title), h('div', { class: 'bar', style: `background:linear-gradient(90deg,${stops})` }), h('div', { class: 'ticks' }, ...scale.ticks.map(([, t]) => h('span', {}, t))),
    world.colourBy === 'error' ? h('span', { class: 'note' }, 'Blue: missed. Grey: too thin to say.') : '', q2);
};

// ---- The game

game.onRound = (object) => {
  const playing = object >= 0;
  hand.letGo();
  hand.only = object;
  world.hidden = playing;
  hideTool();
  world.frame(playing ? object : -1);
  if (playing) { select(-1, -1); world.mark(null); if (!sound.on) sound.start(); voice.on = true; for (const id of ['sound', 'voice']) senses.querySelector<HTMLInputElement>(`#${id}`)!.checked = true; hint.textContent = HIDDEN_HINT; hint.hidden = false; canvas.focus(); }
  else { sound.quiet(); hint.hidden = true; }
  showFacts();
  void world.paint();
};
game.onSound = (good) => { sound.tap(good ? 880 : 180); if (good) setTimeout(() => sound.tap(1320), 130); };

// ---- The program

const link = new Link({
  scene(objects) {
    const count = facts.length;
    for (const f of objects) {
      const before = facts.find((g) => g.id === f.id);
      if (before && before.revision !== f.revision) announce(`${f.name}: ${parts(f.parts.length)}${f.edited ? ', edited' : ''}.`);
    }
    facts = objects;
    notice.hidden = true;
    if (selected && !facts[selected.object]) selected = null;
    if (selected && selected.part >= facts[selected.object].parts.length) selected.part = -1;
    showFacts();
    showPart();
    showExports();
    showTools();
    game.scene(facts);
    void world.setScene(facts).then(() => {
      if (first || facts.length !== count) world.frame();
      if (first) restoreLink();
      first = false;
      document.body.dataset.ready = String(frames);
    }).catch((e) => trouble(String(e)));
  },
  status(s) {
    status = s;
    // What is just being set here is newer than what the program says.
    if (!settingsDue && performance.now() - settingsChanged > 400) settings = { ...s.settings };
    world.toolRadius(settings.smoothing > 0 ? settings.smoothing : settings.toolRadius);
    if (document.activeElement !== toolSelect) toolSelect.value = String(settings.tool);
    showToolRows();
    void fetchTool(s.toolRevision);
    tabs.dress.hidden = !s.cloth.here;
    costume.status(s);
    sliders.forEach((x) => x.set());
    (touchPanel.querySelector('#layer') as HTMLSelectElement).value = settings.layer;
    if (deviceSelect.childElementCount !== s.devices.length && s.devices.length) {
      fill(deviceTable, ...s.devices.map((d) => h('tr', {}, h('td', {}, d.name), h('td', {}, `${d.here ? '✓' : '–'} ${d.state}`), h('td', {}, d.rate > 0 ? `${d.rate} Hz` : '–'), h('td', {}, d.limit > 0 ? `${digits(d.limit)} N` : '–'))));
      deviceSelect.replaceChildren(...s.devices.map((d, i) => h('option', { value: String(i), disabled: !d.here }, d.here ? d.name : `${d.name} (not here)`)));
    }
    deviceSelect.value = String(s.device);
    const d = s.devices[s.device];
    deviceFacts.textContent = d ? `${d.state}. ${d.rate} Hz, at most ${digits(s.limit ?? d.limit)} N.${s.safeStiffness && s.safeStiffness < settings.stiffness ? ` Stiffer than this device is proven stable with (${digits(s.safeStiffness)} N/m).` : ''}` : '';
    const c = s.counters;
    counters.textContent = c ? `Servo: ${c.ticks.toLocaleString('en')} ticks; ${c.late} late, ${c.missed} missed, ${c.overruns} over budget, worst ${c.worstLate.toFixed(1)} ms late.` : 'The servo starts with the first touch.';
    showStopped();
    stopButton.setAttribute('aria-pressed', String(s.stopped));
  },
  frame: onFrame,
  cloth(f) { costume.frame(f); },
  progress(p) {
    progressBox.hidden = p.stage === 'done' || p.stage === 'failed';
    const stages: Record<string, [string, number]> = { decompose: ['cutting into parts', 0.1], fit: ['fitting superquadrics', 0.3], map: ['making maps', 0.5], measure: ['measuring', 0.75], refine: ['refining', 0.85], bones: ['its bones', p.done] };
    const [text, at] = stages[p.stage] ?? [p.stage, 1];
    progressText.textContent = `Baking ${p.name}: ${text}`;
    progressBar.value = p.done >= 1 ? 1 : at;
    if (p.stage === 'done' && p.name !== 'the figure') announce(`${p.name} is baked.`);
  },
  trouble,
  connected(yes) {
    connection.textContent = yes ? 'connected' : 'connection lost: no force; trying again …';
    connection.className = yes ? 'pill good' : 'pill bad';
    if (!yes) { sound.quiet(); hideTool(); announce('The connection is lost. There is no force.', true); }
    else { wasHeld = false; toolShown = -1; hand.again(); costume.again(); }
  },
});

costume.onReady = () => { hint.textContent = 'Press on the cloth and drag: it is pulled. Beside it the drag turns the view.'; hint.hidden = false; setTimeout(() => { if (mode === 'dress') hint.hidden = true; }, 6000); };
setMode('look');
showRecorder();
setNumbers([]);
showExports();
theme();

// For the browser tests.
Object.assign(window, { sqmap: { meter, world, hand, charts, game, link, costume, recorder, facts: () => facts, status: () => status, frame: () => lastFrame, frames: () => frames } });
