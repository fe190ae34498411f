// The dialog of all keys, which F1 or a question mark opens.
import { h } from './dom';

const KEYS: [string, [string, string][]][] = [
  [
    'Everywhere',
    [
      ['Space', 'STOP, while anything can be felt'],
      ['F1 or ?', 'these keys'],
      ['◐', 'light, dark, high contrast'],
    ],
  ],
  [
    'Touch and recognise, on the stage',
    [
      ['Enter', 'touch, lift; with nothing near: to the nearest object'],
      ['arrows', 'move the tool; with Shift finely'],
      ['Page Down, Page Up', 'press harder, softer'],
      ['Q, E', 'walk round'],
      ['N', 'say part, force, position and distance'],
    ],
  ],
  [
    'Look, on the stage',
    [
      ['arrows', 'turn; with Shift finely'],
      ['+ and −', 'nearer, farther'],
      ['Home', 'show all'],
      ['Enter', 'numbers of what is in the middle'],
      ['1 to 7', 'from the front, back, left, right, top, below, corner'],
      ['Ctrl+Z', 'take an edit back'],
    ],
  ],
  [
    'Game pad',
    [
      ['left stick', 'move the tool'],
      ['A', 'touch, lift'],
      ['right and left trigger', 'press harder, softer'],
      ['right stick', 'turn'],
      ['shoulders', 'nearer, farther'],
      ['X', 'say part, force, position and distance'],
      ['B', 'STOP'],
    ],
  ],
  [
    'Headset',
    [
      ['move', 'the tool is in the hand, or at the tip of the index finger'],
      ['trigger, pinch', 'take it into this hand; after STOP: go on'],
      ['grip', 'STOP'],
    ],
  ],
  [
    'Dress, on the stage',
    [
      ['arrows', 'move the cross'],
      ['Enter', 'take cloth, let go'],
      ['P', 'pin'],
      ['C', 'begin a cut, end it'],
    ],
  ],
];

const dialog = h(
  'dialog',
  { id: 'keys', 'aria-labelledby': 'keys-title' },
  h('h2', { id: 'keys-title', tabindex: -1, autofocus: true }, 'Keys'),
  ...KEYS.map(([title, rows]) =>
    h(
      'section',
      {},
      h('h3', {}, title),
      h('dl', { class: 'numbers' }, ...rows.flatMap(([key, what]) => [h('dt', {}, h('kbd', {}, key)), h('dd', {}, what)])),
    ),
  ),
  h('button', { class: 'primary', onclick: () => dialog.close() }, 'Close'),
);
const button = h(
  'button',
  { class: 'quiet', id: 'help', 'aria-label': 'All keys', title: 'All keys (F1 or ?)', onclick: () => dialog.showModal() },
  '?',
);

document.addEventListener('keydown', (e) => {
  const at = document.activeElement,
    types = at instanceof HTMLInputElement && at.type === 'text';
  if (e.key !== 'F1' && (e.key !== '?' || types)) return;
  e.preventDefault();
  if (!dialog.open) dialog.showModal();
});

export const help = { dialog, button };
