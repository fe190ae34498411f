// The page: its parts are put together here, and what the program says is handed to them.
import './style.css';
import { announce, h } from './dom';
import { charts, hideTool, pageCost } from './felt';
import { main, panel } from './layout';
import { meter } from './meter';
import { modePanel, setMode, tabList, tabs } from './modes';
import { link, type ObjectFacts } from './net';
import { notice, progressBox, showProgress, trouble } from './notices';
import { card } from './panels/controls';
import { costume } from './panels/dress';
import { dialog, restoreLink, sharePanel, zone } from './panels/files';
import { inspected } from './panels/inspect';
import { pickBox } from './panels/look';
import { count, factsBox } from './panels/models';
import { map, mapCard, showFeet } from './panels/parts';
import { game } from './panels/recognise';
import { hear, recorder } from './panels/recording';
import { sound } from './panels/senses';
import { again, counters } from './panels/touch';
import { hand, stage, world } from './stage';
import { changed, state } from './state';
import { stopButton } from './stop';
import { applyTheme, themeButton } from './theme';

const connection = h('span', { class: 'pill', id: 'connection', role: 'status' }, 'connecting …');
panel.append(notice, progressBox, dialog, mapCard, pickBox, factsBox, modePanel, card('Timing', counters, pageCost), sharePanel);
main.append(stage, panel, charts.element);
document.getElementById('app')!.replaceChildren(h('header', {}, h('h1', {}, 'sqmap'), tabList, connection, themeButton, stopButton), main, zone);

let first = true;

function scene(objects: ObjectFacts[]): void {
  const before = state.facts;
  for (const f of objects) {
    const old = before.find((g) => g.id === f.id);
    if (old && old.revision !== f.revision) announce(`${f.name}: ${count(f.parts.length)}${f.edited ? ', edited' : ''}.`);
  }
  state.facts = objects;
  notice.hidden = true;
  if (state.selected && !objects[state.selected.object]) state.selected = null;
  if (state.selected && state.selected.part >= objects[state.selected.object].parts.length) state.selected.part = -1;
  changed('scene');
  void world.setScene(objects).then(() => {
    if (first || objects.length !== before.length) world.frame();
    if (first) restoreLink();
    first = false;
    document.body.dataset.ready = String(state.frames);
  }).catch((e) => trouble(String(e)));
}

function connected(yes: boolean): void {
  connection.textContent = yes ? 'connected' : 'connection lost: no force; trying again …';
  connection.className = yes ? 'pill good' : 'pill bad';
  if (yes) { again(); costume.again(); return; }
  sound.quiet();
  hideTool();
  announce('The connection is lost. There is no force.', true);
}

setMode('look');
applyTheme();
link.open({
  scene,
  status(s) {
    state.status = s;
    tabs.dress.hidden = !s.cloth.here;
    changed('status');
  },
  frame(f) {
    ++state.frames;
    state.frame = f;
    hand.heard(f.engaged, f.contacts > 0 && !f.engaged && f.faults === 0);
    hear(f);
  },
  cloth(f) { costume.frame(f); },
  feet: showFeet,
  progress: showProgress,
  trouble,
  connected,
});

// For the browser tests.
Object.assign(window, { sqmap: { meter, world, map, inspected, hand, charts, game, link, costume, recorder, facts: () => state.facts, status: () => state.status, frame: () => state.frame, frames: () => state.frames } });
