// STOP, which ends every force at once, and the way back.
import { announce, h } from './dom';
import { link } from './net';
import { canvas, hand, stage } from './stage';
import { on, state } from './state';

export const stopButton = h(
  'button',
  { class: 'stop', id: 'stop', onclick: () => stop() },
  h('span', {}, 'STOP'),
  h('kbd', {}, 'Space'),
);

/// Functions of panels that run when the force ends.
const atStop: (() => void)[] = [];
export function onStop(end: () => void): void {
  atStop.push(end);
}
/// Tests of panels for forces other than the hand's.
const forces: (() => boolean)[] = [];
export function whileFelt(test: () => boolean): void {
  forces.push(test);
}

/// Tells whether the mode or the device can give a force; STOP is shown then.
const canBeFelt = (): boolean => state.mode !== 'look' || (state.status?.device ?? 0) > 0;

let before: HTMLElement | null = null; ///< the element that had the focus

function stop(): void {
  before = document.activeElement instanceof HTMLElement ? document.activeElement : null;
  link.say({ say: 'stop' });
  hand.letGo();
  for (const end of atStop) end();
  announce('Stopped. No force.', true);
}
let resumed = -1e9; // ms, the time of the last Resume
function resume(): void {
  resumed = performance.now();
  link.say({ say: 'resume' });
  announce('Going on.');
  (before?.isConnected && before !== document.body && before !== stopButton ? before : canvas).focus();
}

document.addEventListener('keydown', (e) => {
  if (e.code !== 'Space') return;
  const at = document.activeElement;
  // A second Space, pressed in fright, must not resume: only Enter does.
  if (at instanceof Element && at.id === 'resume') {
    e.preventDefault();
    return;
  }
  if (!canBeFelt() || document.querySelector('dialog[open]')) return;
  // While a force is possible the space bar is STOP wherever the focus is; else buttons and fields keep it.
  const felt =
    hand.holding ||
    forces.some((test) => test()) ||
    (state.status?.touching && (state.status.device > 0 || (state.frame && state.frame.contacts > 0)));
  if (!felt && at && at !== document.body && at !== canvas) return;
  e.preventDefault();
  stop();
});
window.addEventListener('blur', () => hand.letGo());

function showResume(text = state.mode === 'dress' ? 'Stopped: nothing is held.' : 'Stopped: there is no force.'): void {
  const shown = stage.querySelector('.stopped');
  if (shown) {
    shown.setAttribute('aria-label', text);
    shown.querySelector('p')!.textContent = text;
    return;
  }
  const button = h('button', { id: 'resume', class: 'primary', onclick: () => resume() }, 'Resume ', h('kbd', {}, 'Enter'));
  stage.append(h('div', { class: 'stopped', role: 'alertdialog', 'aria-label': text }, h('p', {}, text), button));
  button.focus();
}
/// Shows Resume when a frame says that the filter has stopped the force. Frames that were sent before the last Resume do not count.
export function heardStop(): void {
  if (performance.now() - resumed > 500) showResume();
}
function hideResume(): void {
  stage.querySelector('.stopped')?.remove();
}
/// Shows or hides Resume; in Look it would only be in the way.
function showStopped(): void {
  if (state.status?.stopped && state.mode !== 'look') showResume();
  else hideResume();
}
on(['mode', 'status'], () => {
  showStopped();
  stopButton.hidden = !canBeFelt();
  if (state.status) stopButton.setAttribute('aria-pressed', String(state.status.stopped));
});
