// The tabs Touch, Look, Recognise and Dress, and the changes that go with each.
import { announce, h } from './dom';
import { hideTool } from './felt';
import { main, panel } from './layout';
import { link, saved } from './net';
import { costume, dressPanel } from './panels/dress';
import { lookPanel } from './panels/look';
import { gamePanel, HIDDEN_HINT } from './panels/recognise';
import { recorder } from './panels/recording';
import { senses } from './panels/senses';
import { touchPanel } from './panels/touch';
import { canvas, hand, hint, showHint, world } from './stage';
import { changed, MODES, state, type Mode } from './state';

export const tabs: Record<Mode, HTMLButtonElement> = {
  touch: tab('touch', 'Touch'),
  look: tab('look', 'Look'),
  recognise: tab('recognise', 'Recognise'),
  dress: tab('dress', 'Dress'),
};
function tab(which: Mode, text: string): HTMLButtonElement {
  return h(
    'button',
    {
      role: 'tab',
      id: `tab-${which}`,
      'aria-controls': 'panel',
      onclick: () => {
        setMode(which);
        announce(PURPOSES[which]);
      },
    },
    text,
  );
}
/// The words for those who hear a tab.
const PURPOSES: Record<Mode, string> = {
  touch: 'Touch: on the stage Enter touches, arrow keys move the tool, N says where it is.',
  look: 'Look: on the stage arrow keys turn the view, Enter gives numbers.',
  recognise: 'Recognise: an object is hidden, and touch and sound say which it is. Begin is in the panel.',
  dress: 'Dress: a figure wears cloth; on the stage Enter takes it.',
};
export const tabList = h(
  'div',
  {
    class: 'tabs',
    role: 'tablist',
    'aria-label': 'What to do',
    onkeydown: (e: Event) => {
      const order = MODES.filter((m) => !tabs[m].hidden),
        key = (e as KeyboardEvent).key;
      const by = key === 'ArrowRight' ? 1 : key === 'ArrowLeft' ? -1 : 0;
      if (!by) return;
      const next = order[(order.indexOf(state.mode) + by + order.length) % order.length];
      setMode(next);
      tabs[next].focus();
      announce(PURPOSES[next]);
    },
  },
  ...Object.values(tabs),
);
/// The panel of the mode.
export const modePanel = h('div', { id: 'mode-panel' });
const hints: Record<Mode, string> = {
  look: `Drag to turn it. Click it for numbers.${saved ? '' : ' Drop a mesh here to bake it.'}`,
  touch: '',
  recognise: 'Press Begin, then feel for the hidden object with sound on.',
  dress: 'The figure is being prepared: some seconds.',
};

export function setMode(next: Mode): void {
  hand.letGo();
  recorder.halt();
  if (state.mode !== next) panel.scrollTop = 0;
  const before = state.mode;
  state.mode = next;
  for (const [m, b] of Object.entries(tabs)) {
    b.setAttribute('aria-selected', String(m === state.mode));
    b.tabIndex = m === state.mode ? 0 : -1;
  }
  modePanel.replaceChildren({ look: lookPanel, touch: touchPanel, recognise: gamePanel, dress: dressPanel }[next]);
  panel.querySelector('.senses')?.append(senses);
  panel.setAttribute('aria-labelledby', `tab-${state.mode}`);
  main.dataset.mode = state.mode;
  if (!state.playing && !hints[next]) hint.hidden = true;
  else
    showHint(
      state.playing && state.mode !== 'dress'
        ? state.mode === 'recognise'
          ? HIDDEN_HINT
          : 'A round of recognition goes on: the objects stay hidden until you leave the game.'
        : hints[state.mode],
    );
  hand.enabled = state.mode === 'touch' || state.mode === 'recognise';
  if (state.mode !== 'recognise') hand.only = state.playing ? hand.only : -1;
  world.objects.hidden = state.mode === 'dress' || state.playing;
  canvas.classList.toggle('touching', hand.enabled);
  changed('mode');
  if (before !== state.mode && state.mode === 'dress') {
    world.tool.mark(null);
    if (costume.last) hint.hidden = true;
    costume.enter();
  }
  if (before === 'dress' && state.mode !== 'dress') {
    costume.leave();
    world.tool.mark(null);
    world.frame();
  }
  if (state.mode === 'look' || state.mode === 'dress') {
    hideTool();
    link.say({ say: 'rest' });
  }
  world.objects.dims = state.mode === 'look';
  void world.objects.paint();
}
