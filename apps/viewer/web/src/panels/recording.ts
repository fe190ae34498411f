// Recordings of touch: recorded, replayed, computed again by the program, saved and opened.
import { h, digits, save } from '../dom';
import { charts, draw, hideTool, show } from '../felt';
import type { Frame, Verdict } from '../messages';
import { fetchBytes, link, readFrames, upload } from '../net';
import { trouble, wait } from '../notices';
import { readAgain, Recorder } from '../recorder';
import { endInvitation } from '../first';
import { hand, world } from '../stage';
import { on, state } from '../state';
import { onStop } from '../stop';
import { card } from './controls';
import { sound } from './senses';

export const recorder = new Recorder();

const recordButton = h('button', {
  id: 'record',
  onclick: () => {
    if (recorder.recording) endRecording();
    else {
      recorder.halt();
      recorder.start();
      againWords.textContent = '';
      link.say({ say: 'record', on: true });
    }
    showRecorder();
  },
});
const replayButton = h('button', {
  id: 'replay',
  onclick: () => {
    if (recorder.replaying && !recorder.paused) recorder.pause();
    else {
      hand.letGo();
      if (!recorder.paused) charts.clear();
      recorder.replay();
    }
    showRecorder(recorder.position);
  },
});
const toNow = h(
  'button',
  {
    id: 'to-now',
    onclick: () => {
      recorder.halt();
      showRecorder();
    },
  },
  'Back to now',
);
const scrub = h('input', {
  type: 'range',
  id: 'scrub',
  min: '0',
  max: '1',
  step: '0.01',
  value: '0',
  'aria-label': 'Moment of the recording',
  oninput: () => {
    hand.letGo();
    recorder.seek(Number(scrub.value));
  },
});
const marks = h('div', { class: 'marks', 'aria-hidden': 'true' });
const MARKS = { contact: 'contact', limit: 'at the force limit', fault: 'the filter stopped the force' },
  spanWords = h('span', { id: 'spans' });
const timeline = h(
  'div',
  { class: 'timeline', id: 'timeline', hidden: true },
  marks,
  scrub,
  h(
    'div',
    { class: 'note' },
    '▌contact  ',
    h('span', { class: 'limit' }, '▌limit  '),
    h('span', { class: 'fault' }, '▌fault  '),
    spanWords,
  ),
);
recorder.onSeek = (frames, at) => {
  charts.clear();
  for (const f of frames) charts.add(f, recorder.againOf(f));
  const last = frames.at(-1);
  if (last) draw(last);
  showRecorder(at);
};
charts.onPick = (ago) => {
  if (recorder.replaying) recorder.seek(recorder.position - ago);
};
/// Saves the recording with the poses of every tick, which the program has.
const saveButton = h(
  'button',
  {
    id: 'save-recording',
    title: 'To open again here, also tomorrow',
    onclick: async () => {
      try {
        save('touch.csv', await fetchBytes('/api/recording'), 'text/csv');
      } catch (e) {
        trouble(e);
      }
    },
  },
  'Save',
);
const tableButton = h(
  'button',
  {
    id: 'save-table',
    title: 'What was drawn, for a spreadsheet',
    onclick: () => save('touch-table.csv', recorder.csv(), 'text/csv'),
  },
  'Table',
);
const recordingInput = h('input', {
  type: 'file',
  id: 'recording-file',
  hidden: true,
  'aria-label': 'Recording',
  accept: '.csv',
  onchange: async () => {
    const f = recordingInput.files?.[0];
    recordingInput.value = '';
    if (!f) return;
    try {
      const v = await openRecording(f, () => {}, new AbortController().signal);
      if (!v.accepted) trouble(`${v.message}. What helps: ${v.cure}.`);
    } catch (e) {
      trouble(`${f.name}: ${e instanceof Error ? e.message : e}`);
    }
  },
});

/// Opens a recording. A file that begins as a trace has the poses of every tick and goes to the program; the page reads a table itself.
export async function openRecording(file: File, sent: (share: number) => void, signal: AbortSignal): Promise<Verdict> {
  if (recorder.recording) throw new Error('stop recording first');
  let verdict: Verdict = { accepted: true, verdict: 'TABLE' };
  if ((await file.slice(0, 14).text()).startsWith('# sqmap-trace ')) {
    verdict = await upload(file, null, sent, signal);
    if (verdict.accepted) {
      await fetchRecording();
      if (recorder.touched >= 0 && !world.sees(recorder.touched)) world.frame(recorder.touched);
    }
  } else recorder.open(await file.text());
  if (verdict.accepted) {
    endInvitation();
    wait(
      `${file.name}: ${recorder.seconds.toFixed(1)} s, ready to replay.${(verdict.notes ?? []).map((note) => ` ${note}.`).join('')}`,
    );
  }
  showRecorder();
  return verdict;
}
async function fetchRecording(): Promise<void> {
  recorder.take(readFrames(await fetchBytes('/api/recording/frames')));
  againWords.textContent = '';
  showRecorder();
}
// The page may be loaded anew while the program goes on, and the program may be started anew while the page stays.
let program = '',
  asked = false;
on(['status'], () => {
  const s = state.status!;
  if (program && program !== s.program) {
    recorder.forget();
    showRecorder();
  }
  program = s.program;
  if (!asked && s.recorded && !recorder.count && !recorder.recording) void fetchRecording().catch(trouble);
  asked = true;
});
const recordingWords = h('p', { class: 'note', id: 'recording' }),
  againWords = h('p', { id: 'again-words', role: 'status' });
function endRecording(): void {
  recorder.stop();
  link.say({ say: 'record', on: false });
}
recorder.onFull = () => {
  endRecording();
  showRecorder();
};
const againButton = h('button', { id: 'again', onclick: () => void computeAgain() }, 'Compute again');

/// Computes the recording again: first with the objects and settings of then, which must give the same bits, then with those of now.
async function computeAgain(): Promise<void> {
  againButton.disabled = true;
  againWords.textContent = 'Computing every tick again …';
  try {
    const then = readAgain(await fetchBytes('/api/again/then')),
      now = readAgain(await fetchBytes('/api/again/now')),
      ticks = then.ticks.length / 3;
    recorder.again = now;
    const n = ticks.toLocaleString('en');
    const proof =
      then.different === 0
        ? `✓ ${n} ticks, computed again: every force is the same to the bit.`
        : `✗ ${n} ticks, computed again: ${then.different.toLocaleString('en')} differ, by at most ${digits(then.largestForce)} N.${then.lost ? ` ${then.lost} ticks were lost while recording: what has a memory may differ after them.` : ''}`;
    const change =
      now.different === 0
        ? 'With the objects and settings of now: the same.'
        : `With the objects and settings of now the force differs by at most ${digits(now.largestForce)} N (root mean square ${digits(now.rmsForce)} N), the depth by ${digits(1000 * now.largestDepth)} mm.`;
    againWords.textContent = `${proof} ${change} Replay draws it dashed, before the safety filter.`;
  } catch (e) {
    againWords.textContent = '';
    trouble(e);
  }
  showRecorder();
}
function showRecorder(at = recorder.replaying ? recorder.position : 0): void {
  recordButton.textContent = recorder.recording ? 'Stop recording' : 'Record';
  recordButton.setAttribute('aria-pressed', String(recorder.recording));
  replayButton.textContent = !recorder.replaying ? 'Replay' : recorder.paused ? 'Go on' : 'Pause';
  toNow.hidden = !recorder.replaying;
  timeline.hidden = recorder.count === 0 || recorder.recording;
  scrub.max = String(recorder.seconds);
  if (document.activeElement !== scrub) scrub.value = String(at);
  scrub.setAttribute('aria-valuetext', `${at.toFixed(2)} of ${recorder.seconds.toFixed(2)} seconds`);
  const key = `${recorder.count} ${recorder.seconds}`;
  if (!timeline.hidden && marks.dataset.key !== key) {
    marks.dataset.key = key;
    const all = recorder.spans(),
      share = (t: number) => ((100 * t) / Math.max(recorder.seconds, 0.01)).toFixed(2),
      contacts = all.filter((m) => m.kind === 'contact');
    marks.replaceChildren(
      ...all.map((m) =>
        h('i', {
          class: m.kind,
          title: `${MARKS[m.kind]}: ${m.from.toFixed(2)} to ${m.to.toFixed(2)} s`,
          style: `left:${share(m.from)}%;width:max(${share(m.to - m.from)}%,2px)`,
        }),
      ),
    );
    spanWords.textContent = `${contacts.length} contact${contacts.length === 1 ? '' : 's'}, ${contacts.reduce((sum, m) => sum + m.to - m.from, 0).toFixed(1)} s in all.`;
  }
  replayButton.disabled = tableButton.disabled = recorder.count === 0 || recorder.recording;
  againButton.disabled = saveButton.disabled = !recorder.known || recorder.recording;
  recordingWords.textContent = recorder.recording
    ? 'Recording every tick …'
    : recorder.replaying
      ? `${recorder.paused ? 'Standing at' : 'Replaying:'} ${at.toFixed(recorder.paused ? 2 : 1)} of ${recorder.seconds.toFixed(1)} s`
      : !recorder.count
        ? 'Nothing recorded yet.'
        : !recorder.known
          ? `${recorder.seconds.toFixed(1)} s as they were drawn, without the poses of every tick: to replay, not to compute again.`
          : `${recorder.seconds.toFixed(1)} s recorded.${recorder.known < recorder.seconds - 0.5 ? ` Save and Compute again have the first ${recorder.known.toFixed(0)} s, the table all.` : ''}`;
}
recorder.onFrame = (frame, at) => {
  show(frame, true, recorder.againOf(frame));
  draw(frame);
  showRecorder(at);
};
recorder.onEnd = () => {
  hideTool();
  sound.quiet();
  showRecorder();
};
onStop(() => recorder.halt());

/// Records a frame of the servo where recording is on, and shows it where no recording is replayed.
export function hear(frame: Frame): void {
  recorder.add(frame);
  if (recorder.recording) recordingWords.textContent = `Recording every tick: ${recorder.seconds.toFixed(0)} s`;
  if (!recorder.replaying) show(frame);
}

export const recordingCard = card(
  'Recording',
  h(
    'div',
    { class: 'row wrap' },
    recordButton,
    replayButton,
    toNow,
    againButton,
    saveButton,
    tableButton,
    h('button', { id: 'open-recording', onclick: () => recordingInput.click() }, 'Open …'),
    recordingInput,
  ),
  timeline,
  recordingWords,
  againWords,
);
showRecorder();
