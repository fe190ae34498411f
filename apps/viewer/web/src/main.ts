// Puts the page together, and hands the program's messages to its parts.
import './style.css';
import { distinctColours } from './colours';
import { announce, h } from './dom';
import { charts, hideTool, pageCost } from './felt';
import { help } from './help';
import { edge, main, panel, sheet } from './layout';
import { meter } from './meter';
import { modePanel, setMode, tabList, tabs } from './modes';
import { vector } from './geometry';
import type { Scene } from './messages';
import { link, packed, program, saved } from './net';
import { notice, progressBox, question, settle, showProgress, trouble, wait } from './notices';
import { folded } from './panels/controls';
import { costume } from './panels/dress';
import { endInvitation, firstMinute, lookAt } from './first';
import { dialog, exportMenu, heardProgress, openButton, readingButton, zone } from './panels/files';
import { restoreView } from './session';
import { inspected } from './panels/inspect';
import { shownMeetings } from './panels/meetings';
import './pad';
import { answersBox, dropPick, pickBox } from './panels/picked';
import { showEmpty } from './empty';
import { count } from './panels/models';
import { factsBox } from './panels/tree';
import { map, mapCard, showFeet } from './panels/parts';
import { game } from './panels/recognise';
import { hear, recorder } from './panels/recording';
import { sound, soundButton } from './panels/senses';
import { leaveOut, restorePacked, restoreSaved } from './panels/share';
import { sweep } from './panels/sweep';
import { counters } from './panels/device';
import { again } from './panels/touch';
import { hand, stage, world } from './stage';
import { changed, on, state } from './state';
import { stopButton } from './stop';
import { applyTheme, themeButton } from './theme';
import { immersive, immersiveButton } from './immersive';

const connection = h('span', { class: 'pill', id: 'connection', role: 'status' }, 'connecting …');
panel.append(
  notice,
  progressBox,
  dialog,
  modePanel,
  pickBox,
  answersBox,
  mapCard,
  factsBox,
  folded('Timing', 'timing', counters, pageCost),
);
main.append(stage, edge, sheet, panel, charts.element);
document
  .getElementById('app')!
  .replaceChildren(
    h(
      'header',
      {},
      h('h1', {}, 'sqmap'),
      tabList,
      h('div', { class: 'joined' }, openButton, readingButton),
      exportMenu,
      connection,
      soundButton,
      immersiveButton,
      themeButton,
      help.button,
      stopButton,
    ),
    main,
    zone,
    help.dialog,
  );

// The numbers of a picked point stand above the choices of what is drawn.
on(['pick'], () => {
  if (state.pick) modePanel.before(pickBox);
  else modePanel.after(pickBox);
});

leaveOut();
let first = true;
showEmpty();

function scene({ objects, loading, removed }: Scene): void {
  const before = state.facts,
    number = (id: number | undefined) => objects.findIndex((f) => f.id === id),
    selected = before[state.selected?.object ?? -1]?.id,
    picked = before[state.pick?.object ?? -1],
    touched = before[state.touched]?.id;
  for (const f of objects) {
    const old = before.find((g) => g.id === f.id);
    if (old && old.revision !== f.revision && old.up === f.up)
      announce(`${f.name}: ${count(f.parts.length)}${f.edited ? ', edited' : ''}.`);
  }
  Object.assign(state, { facts: objects, loading, removed });
  settle();
  // The selection, the picked point and the touch go with their object, whatever its number is now.
  state.touched = number(touched);
  if (state.selected) state.selected = number(selected) < 0 ? null : { ...state.selected, object: number(selected) };
  const own = objects[number(picked?.id)];
  if (state.pick && (!own || own.hidden || own.up !== picked.up)) dropPick();
  else if (state.pick) {
    state.pick.object = objects.indexOf(own);
    state.pick.point.add(vector(own.position).sub(vector(picked.position)));
    world.tool.mark(state.pick.point);
  }
  if (state.selected && state.selected.part >= objects[state.selected.object].parts.length) state.selected.part = -1;
  changed('scene');
  const fresh = objects.findIndex((f) => !before.some((g) => g.id === f.id));
  void world
    .setScene(objects)
    .then(() => {
      if (first) {
        if (objects.length > before.length || !loading) firstMinute();
      } else if (fresh >= 0) showFresh(fresh);
      else if (objects.length < before.length) {
        world.frame();
        lookAt(-1);
      }
      if (loading) return;
      if (first && saved) restoreSaved();
      else if (first && packed) void restorePacked().catch(trouble);
      else if (first) restoreView();
      first = false;
      document.body.dataset.ready = String(state.frames);
    })
    .catch((e) => trouble(e));
}

/// Brings a new object into view. The other kind of maps is drawn beside its object, from the same side: there the eye looks.
function showFresh(object: number): void {
  const pair = world.objects.beside === 'twin' ? world.objects.pair() : null;
  if (pair?.includes(object)) {
    world.frame(pair[0], world.direction());
    return;
  }
  lookAt(object);
  world.frameClosely(object);
}

/// Words for a connection that stands, and for one that is lost.
const WORDS = {
  server: ['connected', 'connection lost: no force; trying again …'],
  worker: ['in this page', 'ended: no force'],
  kept: ['a saved page', ''],
};
function connected(yes: boolean): void {
  connection.textContent = WORDS[program.kind][yes ? 0 : 1];
  connection.className = yes ? 'pill good' : 'pill bad';
  if (yes) {
    again();
    costume.again();
    return;
  }
  sound.quiet();
  hideTool();
  state.frame = null;
  charts.clear();
  counters.textContent = 'The program does not answer.';
  announce('The connection is lost. There is no force.', true);
}

setMode(saved && !saved.recording ? 'look' : 'touch');
applyTheme();
link.open({
  scene,
  status(s) {
    if (state.status && state.status.program !== s.program) {
      wait('The program has been started anew.');
      announce('The program has been started anew.', true);
    }
    state.status = s;
    tabs.dress.hidden = !s.cloth.here;
    changed('status');
  },
  frame(f) {
    ++state.frames;
    state.frame = f;
    if (f.contacts > 0 && f.object >= 0 && f.object !== state.touched) {
      state.touched = f.object;
      changed('touched');
    }
    hand.heard(f.engaged, f.contacts > 0 && !f.engaged && f.faults === 0);
    hear(f);
  },
  cloth(f) {
    costume.frame(f);
  },
  feet: showFeet,
  progress(p) {
    showProgress(p);
    heardProgress(p);
  },
  trouble,
  connected,
  stranger() {
    connection.textContent = 'another program is running here';
    endInvitation();
    question(
      'A new program is running at this address, and only the address that it printed opens it: look where sqmap view was started.',
      'I have read it',
      () => {},
    );
  },
  held() {
    question('Another window has the tool in hand.', 'Take it over', () => link.say({ say: 'take' }));
  },
  taken() {
    hand.letGo();
    trouble('Another window has taken the tool over.');
  },
});

// For the browser tests.
Object.assign(window, {
  sqmap: {
    distinctColours,
    meter,
    world,
    map,
    inspected,
    shownMeetings,
    hand,
    charts,
    game,
    sweep,
    link,
    costume,
    recorder,
    immersive,
    facts: () => state.facts,
    status: () => state.status,
    frame: () => state.frame,
    frames: () => state.frames,
  },
});
