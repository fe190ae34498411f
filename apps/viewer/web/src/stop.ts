// STOP, which ends every force at once, and the way back.
import { announce, h } from './dom';
import { link } from './net';
import { canvas, hand, stage } from './stage';
import { on, state } from './state';

export const stopButton = h('button', { class: 'stop', id: 'stop', onclick: () => stop() }, h('span', {}, 'STOP'), h('kbd', {}, 'Space'));

/// What ends with the force: each panel adds its own.
const atStop: (() => void)[] = [];
export function onStop(end: () => void): void { atStop.push(end); }
/// Forces that the page knows of besides the hand's.
const forces: (() => boolean)[] = [];
export function whileFelt(test: () => boolean): void { forces.push(test); }

function stop(): void {
  link.say({ say: 'stop' });
  hand.letGo();
  for (const end of atStop) end();
  announce('Stopped. No force.', true);
}
function resume(): void { link.say({ say: 'resume' }); announce('Going on.'); canvas.focus(); }

document.addEventListener('keydown', (e) => {
  if (e.code !== 'Space') return;
  const at = document.activeElement;
  // While anything can be felt the space bar is STOP wherever the focus is; else buttons and fields keep it.
  const felt = hand.holding || forces.some((test) => test()) || (state.status?.touching && (state.status.device > 0 || (state.frame && state.frame.contacts > 0)));
  if (!felt && at && at !== document.body && at !== canvas) return;
  e.preventDefault();
  stop();
});
window.addEventListener('blur', () => hand.letGo());

export function showResume(text = 'Stopped: there is no force.'): void {
  if (stage.querySelector('#resume')) return;
  stage.append(h('div', { class: 'stopped', role: 'alertdialog', 'aria-label': text }, h('p', {}, text), h('button', { id: 'resume', class: 'primary', onclick: () => resume() }, 'Resume')));
}
function hideResume(): void { stage.querySelector('.stopped')?.remove(); }
/// Where nothing is felt it is in nobody's way.
function showStopped(): void { if (state.status?.stopped && (state.mode === 'touch' || state.mode === 'recognise')) showResume(); else hideResume(); }
on(['mode', 'status'], () => {
  showStopped();
  if (state.status) stopButton.setAttribute('aria-pressed', String(state.status.stopped));
});
