// Settings of the forces, the tool and the device.
import { announce, digits, fill, h } from '../dom';
import { fetchBytes, link, program } from '../net';
import { trouble } from '../notices';
import { hand, hint, world } from '../stage';
import { changed, on, state } from '../state';
import { MATERIALS, PLAIN } from '../materials';
import { pressBox } from '../press';
import { card, check, choice, folded } from './controls';
import { recordingCard } from './recording';
import { sound } from './senses';
import { sweep } from './sweep';

const sliders: { set(): void }[] = [];
function slider(
  label: string,
  unit: string,
  range: [number, number, number],
  get: () => number,
  set: (x: number) => void,
  live = true,
): HTMLElement {
  const id = `s-${label.toLowerCase().replace(/[^a-z]+/g, '-')}`;
  const read = h('output', { for: id }),
    input = h('input', { type: 'range', id, min: String(range[0]), max: String(range[1]), step: String(range[2]) });
  const show = () => {
    read.textContent = `${digits(Number(input.value), 4)} ${unit}`;
    input.setAttribute('aria-valuetext', read.textContent);
  };
  input.addEventListener('input', () => {
    show();
    if (live) {
      set(Number(input.value));
      tellSettings();
    }
  });
  input.addEventListener('change', () => {
    if (!live) {
      set(Number(input.value));
      tellSettings();
    }
  });
  sliders.push({
    set: () => {
      if (document.activeElement !== input) {
        input.value = String(get());
      }
      show();
    },
  });
  return h('label', { class: 'field slider' }, h('span', {}, label), input, read);
}
const layerChoice = choice(
  'Layer',
  [
    ['tool', 'As the tool needs'],
    ['auto', 'Auto (tolerance)'],
    ['2', '2: base map'],
    ['3', '3: refined map'],
    ['gate', 'Gate k_L: 2 or 3'],
    ['exact', 'Exact triangles'],
  ],
  'tool',
  (v) => {
    state.settings.layer = v;
    tellSettings();
    showRows();
  },
  'layer',
);
const toleranceRow = slider(
  'Tolerance',
  'mm',
  [0, 2, 0.05],
  () => 1000 * state.settings.tolerance,
  (x) => {
    state.settings.tolerance = x / 1000;
  },
);
const forceChoice = choice(
  'Force',
  [
    ['full', 'Full'],
    ['paper', 'The paper’s'],
  ],
  'full',
  (v) => {
    state.settings.paperForce = v === 'paper';
    state.settings.law = v === 'paper' ? 'paper' : 'coulomb';
    tellSettings();
    showRows();
  },
  'force-law',
  'The paper’s: eqs. 21, 26 and 32',
);
const followChoice = choice(
  'The tool',
  [
    ['proxy', 'Stays on the surface'],
    ['direct', 'Goes where the hand is'],
  ],
  'proxy',
  (v) => {
    state.settings.proxy = v === 'proxy';
    tellSettings();
  },
  'follow',
);
const lawChoice = choice(
  'Friction law',
  [
    ['coulomb', 'Coulomb'],
    ['paper', 'The paper’s'],
    ['none', 'None'],
  ],
  'coulomb',
  (v) => {
    state.settings.law = v;
    tellSettings();
    showRows();
  },
  'law',
  'The paper’s: eq. 33',
);
const muRow = slider(
  'Friction',
  '',
  [0, 1, 0.05],
  () => state.settings.friction,
  (x) => {
    state.settings.friction = x;
  },
);
const printedRows = [
  slider(
    'f_c',
    'N',
    [0, 1, 0.02],
    () => state.settings.fC,
    (x) => {
      state.settings.fC = x;
    },
  ),
  slider(
    'k_f',
    '1/m',
    [0, 500, 10],
    () => state.settings.kF,
    (x) => {
      state.settings.kF = x;
    },
  ),
  h('p', { class: 'note' }, 'f_c (1 + k_f depth) against the motion, whatever the load; none at rest.'),
];
/// How the paper's maps are read; objects with central maps pass over all of these but the gate.
const gateRow = slider(
  'Gate k_L',
  '',
  [0, 100, 1],
  () => state.settings.gate,
  (x) => {
    state.settings.gate = x;
  },
  false,
);
const projectorChoice = choice(
  'Foot search',
  [
    ['newton', 'Newton'],
    ['pyramid', 'Pyramid, corrected'],
    ['printed', 'As printed'],
  ],
  'newton',
  (v) => {
    state.settings.projector = v;
    tellSettings();
    showRows();
  },
  'touch-projector',
  'Eqs. 15 to 19; as printed the depth is eq. 21’s',
);
const stepsRow = slider(
  'Nearest steps',
  '',
  [0, 8, 1],
  () => state.settings.nearestSteps,
  (x) => {
    state.settings.nearestSteps = x;
  },
  false,
);
const readings = [
  check(
    'Openings behind the first surface',
    true,
    (on) => {
      state.settings.gaps = on;
      tellSettings();
    },
    'touch-gaps',
  ),
  check(
    'Parts prove points free',
    true,
    (on) => {
      state.settings.pruning = on;
      tellSettings();
    },
    'touch-pruning',
    'Pruning of section 2',
  ),
  check(
    'Offset',
    false,
    (on) => {
      state.settings.offset = on;
      tellSettings();
    },
    'touch-offset',
    'Eq. 12, with the paper’s force',
  ),
];
const paperRows = [projectorChoice, stepsRow, ...readings];
function showRows(): void {
  const s = state.settings;
  const anyPaper = state.facts.some((f, i) => i !== s.tool && !f.central);
  // As paper::idle_option has it: hidden where they change nothing.
  for (const r of paperRows) r.hidden = !anyPaper || s.layer === 'exact';
  stepsRow.hidden ||= s.layer === '2' || s.projector !== 'newton';
  readings[0].hidden ||= s.layer === '2';
  readings[2].hidden ||= !s.paperForce;
  gateRow.hidden = s.layer !== 'gate';
  for (const [id, value] of [
    ['touch-gaps', s.gaps],
    ['touch-pruning', s.pruning],
    ['touch-offset', s.offset],
    ['touch-edges', s.edges],
  ] as [string, boolean][]) {
    const box = touchPanel.querySelector<HTMLInputElement>(`#${id}`)!;
    if (document.activeElement !== box) box.checked = value;
  }
  toleranceRow.hidden = s.layer !== 'auto';
  muRow.hidden = s.law !== 'coulomb';
  for (const r of printedRows) r.hidden = s.law !== 'paper';
  for (const [id, value] of [
    ['layer', s.layer],
    ['law', s.law],
    ['force-law', s.paperForce ? 'paper' : 'full'],
    ['follow', s.proxy ? 'proxy' : 'direct'],
    ['touch-projector', s.projector],
  ]) {
    const select = touchPanel.querySelector<HTMLSelectElement>(`#${id}`)!;
    if (document.activeElement !== select) select.value = value;
  }
  // Objects with central maps do not have the paper's force. The object in the hand does not count.
  const others = state.facts.filter((_, i) => i !== s.tool);
  touchPanel.querySelector<HTMLOptionElement>('#force-law option[value=paper]')!.disabled = others.some((f) => f.central);
}
const toolSelect = h('select', {
  id: 'tool',
  onchange: () => {
    const v = toolSelect.value;
    state.settings.tool = v === 'ball' || v === 'hand' ? v : Number(v);
    hand.letGo();
    tellSettings();
    showToolRows();
  },
});
const deviceSelect = h('select', { id: 'device', onchange: () => link.say({ say: 'device', device: Number(deviceSelect.value) }) });
const deviceTable = h('tbody', { id: 'devices' });
const deviceFacts = h('p', { class: 'note', id: 'device-facts' });
export const counters = h('p', { class: 'note', id: 'counters' });
const pressRead = slider(
  'Press',
  'mm',
  [-2, 20, 0.5],
  () => 1000 * hand.press,
  (x) => {
    hand.press = x / 1000;
    hand.deeper(0);
  },
);
const ballRows = [
  slider(
    'Tool radius',
    'mm',
    [2, 20, 0.5],
    () => 1000 * state.settings.toolRadius,
    (x) => {
      state.settings.toolRadius = x / 1000;
    },
    false,
  ),
  slider(
    'Smoothing',
    'mm',
    [0, 5, 0.25],
    () => 1000 * state.settings.smoothing,
    (x) => {
      state.settings.smoothing = x / 1000;
    },
    false,
  ),
];
const meshRows = [
  slider(
    'Tool size',
    'mm',
    [10, 300, 5],
    () => 1000 * state.settings.toolSize,
    (x) => {
      state.settings.toolSize = x / 1000;
    },
    false,
  ),
  slider(
    'Turn',
    '°',
    [-180, 180, 15],
    () => state.settings.toolTurn,
    (x) => {
      state.settings.toolTurn = x;
    },
    false,
  ),
  slider(
    'Tilt',
    '°',
    [-180, 180, 15],
    () => state.settings.toolTilt,
    (x) => {
      state.settings.toolTilt = x;
    },
    false,
  ),
  check(
    'Its edges touch too',
    false,
    (on) => {
      state.settings.edges = on;
      tellSettings();
    },
    'touch-edges',
    'Edges and faces between its points, where its surface is closed',
  ),
];
function showToolRows(): void {
  for (const r of ballRows) r.hidden = state.settings.tool !== 'ball';
  for (const r of meshRows) r.hidden = state.settings.tool === 'ball';
}
function showTools(): void {
  fill(
    toolSelect,
    h('option', { value: 'ball' }, 'Ball'),
    h('option', { value: 'hand' }, 'Hand'),
    ...state.facts.map((f, i) => (f.hasTriangles ? h('option', { value: String(i) }, `${f.name} (of the scene)`) : null)),
  );
  toolSelect.value = String(state.settings.tool);
  showToolRows();
}

let toolShown = -1;
async function fetchTool(revision: number): Promise<void> {
  if (revision === toolShown) return;
  toolShown = revision;
  const held = typeof state.settings.tool === 'number' ? state.settings.tool : -1;
  if (world.objects.inHand !== held) {
    world.objects.inHand = held;
    void world.objects.paint();
  }
  if (state.settings.tool === 'ball') {
    world.tool.setShape(null, null);
    return;
  }
  try {
    const data = await fetchBytes('/api/tool'),
      [, v, t] = new Uint32Array(data, 0, 3);
    if (revision === toolShown) world.tool.setShape(new Float32Array(data, 12, 3 * v), new Uint32Array(data, 12 + 12 * v, 3 * t));
  } catch (e) {
    toolShown = -1;
    trouble(e);
  }
}

const materialChoice = choice(
  'Material',
  [...Object.entries(MATERIALS).map(([key, m]) => [key, m.name] as [string, string]), ['', 'As set below']],
  'plain',
  (v) => {
    const m = MATERIALS[v];
    if (!m) return;
    Object.assign(state.settings, {
      stiffness: m.stiffness,
      damping: m.damping,
      friction: m.friction,
      texture: m.texture,
      law: 'coulomb',
      paperForce: false,
    });
    tellSettings();
    sliders.forEach((x) => x.set());
    showRows();
  },
  'material',
);
materialChoice.querySelector<HTMLOptionElement>('option[value=""]')!.disabled = true; // the sliders choose it
/// Shows the material whose numbers are set; none where the user has changed them.
function showMaterial(): void {
  const s = state.settings,
    same = (a: number, b: number) => Math.abs(a - b) < 1e-9;
  const key =
    Object.keys(MATERIALS).find((k) => {
      const m = MATERIALS[k];
      return (
        s.law === 'coulomb' &&
        same(s.stiffness, m.stiffness) &&
        same(s.friction, m.friction) &&
        same(s.texture, m.texture) &&
        same(s.damping, m.damping)
      );
    }) ?? '';
  sound.material = MATERIALS[key] ?? PLAIN;
  const select = materialChoice.querySelector('select')!;
  if (document.activeElement !== select || key) select.value = key;
}

export const touchPanel = h(
  'div',
  {},
  card(
    'Feel',
    materialChoice,
    pressRead,
    pressBox,
    slider(
      'Stiffness',
      'N/m',
      [50, 1500, 10],
      () => state.settings.stiffness,
      (x) => {
        state.settings.stiffness = x;
      },
    ),
    muRow,
    ...printedRows,
    sweep.element,
  ),
  recordingCard,
  folded(
    'More settings',
    'more-surface',
    lawChoice,
    slider(
      'Texture',
      'mm',
      [0, 0.6, 0.05],
      () => 1000 * state.settings.texture,
      (x) => {
        state.settings.texture = x / 1000;
      },
      false,
    ),
    slider(
      'Damping',
      'N s/m',
      [0, 2, 0.1],
      () => state.settings.damping,
      (x) => {
        state.settings.damping = x;
      },
    ),
    slider(
      'Force limit',
      'N',
      [0.2, 3.2, 0.1],
      () => state.settings.forceLimit,
      (x) => {
        state.settings.forceLimit = x;
      },
      false,
    ),
    followChoice,
    layerChoice,
    toleranceRow,
    gateRow,
    forceChoice,
    ...paperRows,
  ),
  folded(
    'Tool',
    'more-tool',
    h('label', { class: 'field' }, h('span', {}, 'Tool'), toolSelect),
    ...ballRows,
    ...meshRows,
    slider(
      'Impact zone',
      'mm',
      [0, 40, 1],
      () => 1000 * state.settings.zone,
      (x) => {
        state.settings.zone = x / 1000;
      },
      false,
    ),
    h(
      'p',
      { class: 'note' },
      'Smoothing above 0 makes the ball a point that feels with a sphere of that radius. An impact zone of 0 is the whole tool; a ball has none. A mesh is felt by its corners; one of the scene is not there to be touched while you hold it.',
    ),
  ),
  folded(
    'Device',
    'more-device',
    h('label', { class: 'field' }, h('span', {}, 'Device'), deviceSelect),
    deviceFacts,
    h(
      'details',
      { id: 'device-list' },
      h('summary', {}, 'All devices'),
      h(
        'table',
        {},
        h('thead', {}, h('tr', {}, ...['Device', 'State', 'Rate', 'Limit'].map((t) => h('th', { scope: 'col' }, t)))),
        deviceTable,
      ),
    ),
  ),
  folded('Sound, speech, rumble', 'more-senses', h('div', { class: 'senses' })),
);

// ---- The hand's aim

// The newest aim is sent at most once for each frame of the stream; taking up the tool and letting go are sent at once.
let aim: object | null = null,
  wasHeld = false,
  aimDue = 0;
function sayAim(): void {
  aimDue = 0;
  if (aim) link.say(aim);
  aim = null;
}
hand.onAim = (target, held) => {
  aim = { say: 'touch', p: target.toArray().map((x) => Number(x.toFixed(6))), held };
  if (held !== wasHeld) {
    link.say(aim);
    aim = null;
  }
  wasHeld = held;
  if (aim) aimDue ||= window.setTimeout(sayAim, 16);
  if (held) hint.hidden = true;
};
hand.onKeyTouch = (text) => {
  announce(text);
  if (state.mode === 'touch') sliders.forEach((s) => s.set());
};

let settingsDue = 0,
  heardDue = 0,
  settingsChanged = -1e9;
export function tellSettings(): void {
  settingsChanged = performance.now();
  world.tool.setRadius(state.settings.smoothing > 0 ? state.settings.smoothing : state.settings.toolRadius);
  clearTimeout(settingsDue);
  showMaterial();
  settingsDue = window.setTimeout(() => {
    settingsDue = 0;
    settingsChanged = performance.now();
    link.say({ say: 'settings', ...state.settings });
  }, 40);
}

// ---- Messages of the program

on(['status'], () => {
  const s = state.status;
  if (!s) return;
  // A setting that is being changed here is newer than the program's.
  clearTimeout(heardDue);
  if (!settingsDue && performance.now() - settingsChanged > 400) state.settings = { ...s.settings };
  else heardDue = window.setTimeout(() => changed('status'), 500);
  world.tool.setRadius(state.settings.smoothing > 0 ? state.settings.smoothing : state.settings.toolRadius);
  if (document.activeElement !== toolSelect) toolSelect.value = String(state.settings.tool);
  showToolRows();
  void fetchTool(s.toolRevision);
  sliders.forEach((x) => x.set());
  showRows();
  if (deviceSelect.childElementCount !== s.devices.length && s.devices.length) {
    fill(
      deviceTable,
      ...s.devices.map((d) =>
        h(
          'tr',
          {},
          h('td', {}, d.name),
          h('td', {}, `${d.here ? '✓' : '–'} ${d.state}`),
          h('td', {}, d.rate > 0 ? `${d.rate} Hz` : '–'),
          h('td', {}, d.limit > 0 ? `${digits(d.limit)} N` : '–'),
        ),
      ),
    );
    deviceSelect.replaceChildren(
      ...s.devices.map((d, i) => h('option', { value: String(i), disabled: !d.here }, d.here ? d.name : `${d.name} (not here)`)),
    );
  }
  deviceSelect.value = String(s.device);
  const d = s.devices[s.device];
  deviceFacts.textContent = d
    ? `${d.state}. ${d.rate} Hz, at most ${digits(s.limit ?? d.limit)} N.${s.safeStiffness && s.safeStiffness < state.settings.stiffness ? ` Stiffer than this device is proven stable with (${digits(s.safeStiffness)} N/m).` : ''}`
    : '';
  if (program.kind === 'worker')
    deviceFacts.append(' A page without the program reaches no haptic device and dresses no figure: sqmap view does.');
  const c = s.counters;
  counters.textContent = c
    ? `Servo: ${c.ticks.toLocaleString('en')} ticks; ${c.late} late, ${c.missed} missed, ${c.overruns} over budget, worst ${c.worstLate.toFixed(1)} ms late.`
    : 'The servo starts with the first touch.';
});
on(['status'], showMaterial);
on(['scene'], showTools);
on(['scene'], showRows);

/// Sends tool and grasp again after a lost connection, since the program has forgotten them.
export function again(): void {
  wasHeld = false;
  toolShown = -1;
  hand.again();
  // The program may not know yet that the old connection is gone, and then lets that one hold the tool.
  const retry = setInterval(() => {
    if (hand.waits) hand.again();
    else clearInterval(retry);
  }, 1500);
}
