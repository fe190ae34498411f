// The panel of touch, and the messages that it exchanges with the program: the hand's aim, the settings.
import { announce, h } from '../dom';
import { link } from '../net';
import { hand, hint } from '../stage';
import { changed, on, state } from '../state';
import { folded } from './controls';
import { deviceCard } from './device';
import { feelCard, lawChoice } from './feel';
import { fetchTool, forgetTool, toolCard } from './held_tool';
import { readingRows } from './reading';
import { recordingCard } from './recording';
import { hearSettings, number, pick } from './settings';

export const touchPanel = h(
  'div',
  {},
  feelCard,
  recordingCard,
  folded(
    'More settings',
    'more-surface',
    lawChoice,
    number('Texture', 'mm', [0, 0.6, 0.05], 'texture', 1000, false),
    number('Damping', 'N s/m', [0, 2, 0.1], 'damping'),
    number('Force limit', 'N', [0.2, 3.2, 0.1], 'forceLimit', 1, false),
    pick(
      'The tool',
      [
        ['proxy', 'Stays on the surface'],
        ['direct', 'Goes where the hand is'],
      ],
      () => (state.settings.proxy ? 'proxy' : 'direct'),
      (v) => {
        state.settings.proxy = v === 'proxy';
      },
      'follow',
    ),
    ...readingRows,
  ),
  toolCard,
  deviceCard,
  folded('Sound, speech, rumble', 'more-senses', h('div', { class: 'senses' })),
);

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
  if (state.mode === 'touch') changed('settings'); // the press is shown beside them
};

on(['status'], () => {
  if (!state.status) return;
  hearSettings(state.status.settings);
  void fetchTool(state.status.toolRevision);
});

/// Sends tool and grasp again after a lost connection, since the program has forgotten them.
export function again(): void {
  wasHeld = false;
  forgetTool();
  hand.again();
  // The program may not know yet that the old connection is gone, and then lets that one hold the tool.
  const retry = setInterval(() => {
    if (hand.waits) hand.again();
    else clearInterval(retry);
  }, 1500);
}
