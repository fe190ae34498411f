// An empty stage says what to do, and a stage whose files are still being read says so.
import { h } from './dom';
import { saved } from './net';
import { stage } from './stage';
import { on, state } from './state';

const words = h('p', {}),
  open = h('button', { class: 'primary', onclick: () => document.getElementById('open')?.click() }, 'Open a file …');
const box = h('div', { class: 'empty', id: 'empty', hidden: true }, words, open);

export function showEmpty(): void {
  if (!box.isConnected) stage.append(box);
  const reads = state.loading > 0;
  box.hidden = state.facts.length > 0 || state.mode === 'dress' || !!saved || !state.status;
  words.textContent = reads
    ? 'Reading and baking: the object appears here.'
    : 'Nothing is open. Drop a mesh (OBJ, STL, PLY, OFF, glTF, DAE, 3MF, FBX), a model (.sqmap) or a recording here.';
  open.hidden = reads;
}
on(['scene', 'mode', 'status'], showEmpty);
