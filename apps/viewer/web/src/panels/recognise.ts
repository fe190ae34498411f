// Recognising objects by touch alone: rounds with a hidden object, a guess, a score, and a file of results.
import { announce, fill, h, save } from '../dom';
import { hideTool, onFelt } from '../felt';
import { openSheet } from '../layout';
import type { Frame } from '../messages';
import { canvas, hand, hint, showHint, world } from '../stage';
import { changed, on, state } from '../state';
import { lookAt } from '../first';
import { card } from './controls';
import { select } from './parts';
import { sound, startSenses } from './senses';
import { memory } from '../where';

interface Round {
  practice: boolean;
  object: string;
  guess: string;
  right: boolean;
  confidence: string;
  hash: string;
  seconds: number;
  servo_seconds: number;
  touched_seconds: number;
  path_m: number;
  contacts: number;
}

const ROUNDS = [4, 6, 8, 12];
const CONFIDENCE: [string, string][] = [
  ['', 'not said'],
  ['1', '1: a guess'],
  ['2', '2'],
  ['3', '3'],
  ['4', '4'],
  ['5', '5: certain'],
];

/// A row of a Williams design for n objects: over n rows (2 n where n is odd) each object follows each other one equally often.
function williams(n: number, row: number): number[] {
  const first = Array.from({ length: n }, (_, j) => (j % 2 ? (j + 1) / 2 : (n - j / 2) % n)),
    shift = row % n;
  const out = first.map((x) => (x + shift) % n);
  return n % 2 && Math.floor(row / n) % 2 ? out.reverse() : out;
}

/// The object of each round. Without a participant's number the objects are drawn with replacement, so that earlier rounds give no
/// hint. With a number they follow that row of a Williams design, which balances their order over participants.
function orderOf(objects: number, rounds: number, participant: number | null): number[] {
  if (participant === null) return Array.from({ length: rounds }, () => Math.floor(Math.random() * objects));
  const row = williams(objects, participant);
  return Array.from({ length: rounds }, (_, i) => row[i % objects]);
}

/// Measures of a round. servo, touched: s by the servo's clock since the first touch, and in contact; path: m in contact; before: the
/// tool's position while in contact.
const nothingFelt = () => ({
  began: performance.now(),
  servo: 0,
  touched: 0,
  path: 0,
  contacts: 0,
  before: null as number[] | null,
  lastTime: -1,
});

class Recognise {
  readonly element: HTMLElement;
  private body = h('div', {});
  private ids = ''; ///< the objects of the scene
  private order: number[] = [];
  private rounds: Round[] = [];
  private felt = nothingFelt();
  private participant = h('input', {
    id: 'participant',
    type: 'text',
    maxLength: 40,
    autocomplete: 'off',
    placeholder: 'e.g. P01',
  });
  private count = h('select', { id: 'rounds' }, ...ROUNDS.map((n) => h('option', { value: String(n) }, `${n} rounds`)));
  private drawn = h(
    'select',
    { id: 'order' },
    h('option', { value: 'drawn' }, 'drawn every round'),
    h('option', { value: 'balanced' }, 'balanced, by the number in the name'),
  );
  private practice = h('input', { id: 'practice', type: 'checkbox', checked: true });
  private guessed = false; ///< in this round
  target = -1;
  get running(): boolean {
    return state.playing;
  }

  constructor() {
    this.element = h('div', {}, this.body);
    this.idle();
  }

  scene(): void {
    const ids = state.facts.map((f) => f.id).join();
    if (ids === this.ids) return;
    this.ids = ids;
    if (this.running) {
      this.leave();
      announce('The scene has changed: the game is over.', true);
    }
    this.idle();
  }

  private idle(): void {
    const enough = state.facts.length >= 2;
    fill(
      this.body,
      h(
        'p',
        {},
        'One of the objects is hidden. Feel it, then say which it is. Force is heard as a tone: the harder, the higher and louder.',
      ),
      h('label', { class: 'field' }, h('span', {}, 'Name'), this.participant),
      h('label', { class: 'field' }, h('span', {}, 'Rounds'), this.count),
      h('label', { class: 'field' }, h('span', {}, 'Objects'), this.drawn),
      h('label', { class: 'check' }, this.practice, h('span', {}, 'A practice round first, which does not count')),
      h('button', { class: 'primary', id: 'begin', disabled: !enough, onclick: () => this.begin() }, 'Begin'),
      !enough && h('p', { class: 'note' }, 'This needs two objects or more: open another mesh.'),
    );
  }

  begin(): void {
    const number = this.drawn.value === 'balanced' ? Number(/\d+/.exec(this.participant.value)?.[0] ?? 0) : null;
    this.order = orderOf(state.facts.length, Number(this.count.value), number);
    if (this.practice.checked) this.order.unshift(Math.floor(Math.random() * state.facts.length));
    this.rounds = [];
    state.playing = true;
    this.next();
  }

  private leave(): void {
    state.playing = false;
    this.target = -1;
    showRound(-1);
  }
  private isPractice(round: number): boolean {
    return this.practice.checked && round === 0;
  }
  private titleOf(round: number): string {
    return this.isPractice(round)
      ? 'Practice'
      : `Round ${round + (this.practice.checked ? 0 : 1)} of ${this.order.length - (this.practice.checked ? 1 : 0)}`;
  }

  private next(): void {
    const i = this.rounds.length;
    if (i >= this.order.length) {
      this.finish();
      return;
    }
    this.target = this.order[i];
    this.guessed = false;
    this.felt = nothingFelt();
    memory.forget();
    const names = state.facts.map((f, k) =>
      h('label', { class: 'choice' }, h('input', { type: 'radio', name: 'guess', value: String(k) }), h('span', {}, f.name)),
    );
    const confidence = h(
      'select',
      { name: 'confidence', id: 'confidence' },
      ...CONFIDENCE.map(([v, t]) => h('option', { value: v }, t)),
    );
    const form = h(
      'form',
      {
        onsubmit: (e: Event) => {
          e.preventDefault();
          this.guess(form);
        },
      },
      h('fieldset', {}, h('legend', {}, `${this.titleOf(i)}: which object is it?`), ...names),
      h('label', { class: 'field' }, h('span', {}, 'How sure'), confidence),
      h(
        'div',
        { class: 'row' },
        h('button', { class: 'primary', type: 'submit' }, 'Guess'),
        h(
          'button',
          {
            type: 'button',
            onclick: () => {
              this.leave();
              this.idle();
            },
          },
          'Leave the game',
        ),
      ),
    );
    this.body.replaceChildren(
      h(
        'p',
        {},
        'Explore: drag over the empty stage, or focus it and use the arrow keys. Enter touches and lifts, Page Down presses harder, Q and E walk round, N says what is touched and where the tool is (6 o’clock is near you), Space stops.',
      ),
      form,
    );
    showRound(this.target);
    announce(
      `${this.titleOf(i)}. An object is hidden in the stage. Arrow keys move over it from its middle, Enter touches and lifts.`,
    );
  }

  feel(frame: Frame): void {
    if (!this.running || this.guessed) return;
    const m = this.felt,
      end = frame.time + (frame.ticks.at(-1) ?? 0),
      passed = m.lastTime >= 0 && end > m.lastTime ? Math.min(end - m.lastTime, 0.5) : 0;
    m.lastTime = end;
    m.servo += passed;
    if (frame.contacts === 0) {
      m.before = null;
      return;
    }
    m.touched += passed;
    if (m.before) m.path += Math.hypot(...frame.tool.map((x, i) => x - m.before![i]));
    else ++m.contacts;
    m.before = frame.tool;
  }

  private guess(form: HTMLFormElement): void {
    if (this.guessed) return;
    const data = new FormData(form),
      chosen = data.get('guess');
    if (chosen === null) {
      announce('Choose an object first.', true);
      return;
    }
    this.guessed = true;
    const guess = Number(chosen),
      right = guess === this.target,
      i = this.rounds.length;
    this.rounds.push({
      practice: this.isPractice(i),
      object: state.facts[this.target].name,
      guess: state.facts[guess].name,
      right,
      confidence: String(data.get('confidence') ?? ''),
      hash: state.facts[this.target].hash,
      seconds: (performance.now() - this.felt.began) / 1000,
      servo_seconds: this.felt.servo,
      touched_seconds: this.felt.touched,
      path_m: this.felt.path,
      contacts: this.felt.contacts,
    });
    const words = right ? `✓ Right: it is ${state.facts[guess].name}.` : `✗ Wrong: it was ${state.facts[this.target].name}.`;
    const on = h(
      'button',
      { class: 'primary', id: 'next', onclick: () => this.next() },
      i + 1 < this.order.length ? 'Next round' : 'Result',
    );
    this.body.replaceChildren(
      h('p', { class: `answer ${right ? 'good' : 'bad'}`, id: 'answer-words' }, words),
      h('p', { class: 'note' }, this.isPractice(i) ? 'That was practice: now it counts.' : 'Look at what you felt, then go on.'),
      h('div', { class: 'row' }, on),
    );
    showVerdict(this.target, right);
    announce(words, true);
    on.focus();
  }

  private finish(): void {
    this.leave();
    const counted = this.rounds.filter((r) => !r.practice),
      right = counted.filter((r) => r.right).length,
      seconds = counted.reduce((s, r) => s + r.seconds, 0);
    const score = h('h3', { tabIndex: -1, id: 'score' }, `${right} of ${counted.length} right in ${seconds.toFixed(0)} s`);
    this.body.replaceChildren(
      score,
      h(
        'table',
        {},
        h('thead', {}, h('tr', {}, ...['Object', 'Guess', 'Sure', 'Time'].map((t) => h('th', { scope: 'col' }, t)))),
        h(
          'tbody',
          {},
          ...counted.map((r) =>
            h(
              'tr',
              {},
              h('td', {}, r.object),
              h('td', {}, `${r.right ? '✓' : '✗'} ${r.guess}`),
              h('td', {}, r.confidence || '–'),
              h('td', {}, `${r.seconds.toFixed(1)} s`),
            ),
          ),
        ),
      ),
      h(
        'div',
        { class: 'row' },
        h('button', { class: 'primary', onclick: () => this.saveResults() }, 'Save results'),
        h('button', { onclick: () => this.begin() }, 'Again'),
        h(
          'button',
          {
            onclick: () => {
              this.idle();
              this.participant.focus();
            },
          },
          'Other settings',
        ),
      ),
    );
    score.focus();
    announce(score.textContent ?? '');
  }

  results(): string {
    const head =
      'participant,date,round,practice,object,hash,guess,right,confidence,seconds,servo_seconds,touched_seconds,path_m,contacts';
    // A spreadsheet would read a leading = + - @ as a formula.
    const cell = (s: string) => {
      const t = /^[=+\-@]/.test(s) ? `'${s}` : s;
      return /[",\n]/.test(t) ? `"${t.replaceAll('"', '""')}"` : t;
    };
    const date = new Date().toISOString();
    return (
      [
        head,
        ...this.rounds.map((r, i) =>
          [
            cell(this.participant.value),
            date,
            i + (this.practice.checked ? 0 : 1),
            Number(r.practice),
            cell(r.object),
            r.hash,
            cell(r.guess),
            Number(r.right),
            r.confidence,
            r.seconds.toFixed(2),
            r.servo_seconds.toFixed(3),
            r.touched_seconds.toFixed(3),
            r.path_m.toFixed(4),
            r.contacts,
          ].join(','),
        ),
      ].join('\n') + '\n'
    );
  }

  private saveResults(): void {
    save('recognition.csv', this.results(), 'text/csv');
  }
}

export const game = new Recognise();
export const HIDDEN_HINT = 'Drag over this empty stage, or use the arrow keys: the object is here, unseen.';
export const gamePanel = h(
  'div',
  {},
  card('Recognise by touch', game.element),
  card('Senses', h('p', { class: 'note' }, 'Sound and spoken parts start with the game.'), h('div', { class: 'senses' })),
);

/// Hides all objects and moves the view to one for a round; -1: the game is over.
function showRound(object: number): void {
  const playing = object >= 0;
  hand.letGo();
  hand.only = object;
  world.objects.hidden = playing;
  hideTool();
  lookAt(-1);
  world.frame(playing ? object : -1);
  hand.toMiddle(); // the last round's end would decide where this one begins, and who does not see it has nothing to go by
  if (playing) {
    select(-1, -1);
    world.tool.mark(null);
    startSenses();
    showHint(HIDDEN_HINT);
    openSheet(false);
    canvas.focus();
  } else {
    sound.quiet();
    hint.hidden = true;
  }
  changed('playing');
  void world.objects.paint();
}
/// Shows the object of a round after the guess.
function showVerdict(object: number, right: boolean): void {
  hand.letGo();
  hideTool();
  world.objects.hidden = false; // the object that was touched is shown
  lookAt(object);
  hint.hidden = true;
  void world.objects.paint();
  sound.tap(right ? 880 : 180);
  if (right) setTimeout(() => sound.tap(1320), 130);
}
onFelt((frame) => game.feel(frame));
on(['scene'], () => game.scene());
