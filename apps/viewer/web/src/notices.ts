// Messages that the page shows for a moment, and the progress of a bake.
import { announce, h } from './dom';
import type { Progress } from './messages';

export const notice = h('div', { class: 'notice', id: 'notice', hidden: true });
const progressBar = h('progress', { max: 1, value: 0, 'aria-label': 'Baking' });
const progressText = h('span', {});
export const progressBox = h('div', { class: 'progress', id: 'progress', hidden: true }, progressText, progressBar);

let noticeDue = 0,
  offers = false; // offers: it has a button
/// Shows a text for five seconds, or until the scene changes.
export function wait(text: string): void {
  offers = false;
  notice.hidden = false;
  notice.className = 'notice';
  notice.textContent = text;
  clearTimeout(noticeDue);
  noticeDue = window.setTimeout(() => {
    notice.hidden = true;
  }, 5000);
}
export function trouble(what: unknown): void {
  const text = what instanceof Error ? what.message : String(what);
  wait(text);
  notice.className = 'notice bad';
  announce(text, true);
}
/// Shows a question, which stays until the user answers it.
export function question(text: string, answer: string, act: () => void): void {
  wait(text);
  clearTimeout(noticeDue);
  offers = true;
  notice.append(
    ' ',
    h(
      'button',
      {
        id: 'answer',
        onclick: () => {
          notice.hidden = true;
          act();
        },
      },
      answer,
    ),
  );
  announce(text, true);
}

/// Hides a text that the scene has answered; one with a button stays.
export function settle(): void {
  if (!offers) notice.hidden = true;
}
/// Says what was done, with a button that takes it back, for twelve seconds.
export function undoable(text: string, undo: () => void): void {
  wait(text);
  clearTimeout(noticeDue);
  noticeDue = window.setTimeout(() => {
    notice.hidden = true;
  }, 12000);
  offers = true;
  notice.append(
    ' ',
    h(
      'button',
      {
        id: 'take-back',
        onclick: () => {
          notice.hidden = true;
          undo();
        },
      },
      'Undo',
    ),
  );
  announce(`${text} Undo is in the list of models.`);
}

export function showProgress(p: Progress): void {
  progressBox.hidden = p.stage === 'done' || p.stage === 'failed' || p.stage === 'cancelled';
  const stages: Record<string, [string, number]> = {
    decompose: ['cutting into parts', 0.1],
    fit: ['fitting superquadrics', 0.3],
    map: ['making maps', 0.5],
    measure: ['measuring', 0.75],
    refine: ['refining', 0.85],
    bones: ['its bones', p.done],
  };
  const [text, at] = stages[p.stage] ?? [p.stage, 1];
  progressText.textContent = `Baking${p.name ? ` ${p.name}` : ''}: ${text}`;
  progressBar.value = p.done >= 1 ? 1 : at;
  if (p.stage === 'done' && p.name !== 'the figure') announce(`${p.name} is baked.`);
}
