// Recognising objects by touch alone: rounds with a hidden object, a guess, a score, and a file of results.
import { announce, fill, h, save } from '../dom';
import { hideTool, onFelt } from '../felt';
import { openSheet } from '../layout';
import type { Frame, ObjectFacts } from '../messages';
import { canvas, hand, hint, showHint, world } from '../stage';
import { changed, on, state } from '../state';
import { lookAt } from '../first';
import { card } from './controls';
import { select } from './parts';
import { sound, startSenses } from './senses';

interface Round {
  practice: boolean; object: string; guess: string; right: boolean; confidence: string; hash: string;
  seconds: number; servo_seconds: number; touched_seconds: number; path_m: number; contacts: number;
}

const ROUNDS = [4, 6, 8, 12];
const CONFIDENCE: [string, string][] = [['', 'not said'], ['1', '1: a guess'], ['2', '2'], ['3', '3'], ['4', '4'], ['5', '5: certain']];

/// Row `row` of a Williams design for n things: over n rows (2 n where n is odd) everything follows everything else equally often.
export function williams(n: number, row: number): number[] {
  const first = Array.from({ length: n }, (_, j) => (j % 2 ? (j + 1) / 2 : (n - j / 2) % n)), shift = row % n;
  const out = first.map((x) => (x + shift) % n);
  return n % 2 && Math.floor(row / n) % 2 ? out.reverse() : out;
}

/// One object a round. Drawn with replacement, so that nothing can be guessed from what came before; or, balanced over participants,
/// a row of a Williams design after the other.
export function orderOf(objects: number, rounds: number, participant: number | null): number[] {
  if (participant === null) return Array.from({ length: rounds }, () => Math.floor(Math.random() * objects));
  const row = williams(objects, participant);
  return Array.from({ length: rounds }, (_, i) => row[i % objects]);
}

export class Recognise {
  readonly element: HTMLElement;
  private body = h('div', {});
  private facts: ObjectFacts[] = [];
  private order: number[] = [];
  private rounds: Round[] = [];
  private began = 0;
  // Of the round, by the servo's clock: since the first touch, in contact.
  private servo = 0;
  private touched = 0;
  private path = 0;
  private contacts = 0;
  private before: number[] | null = null;
  private inContact = false;
  private lastTime = -1;
  private participant = h('input', { id: 'participant', type: 'text', maxLength: 40, autocomplete: 'off', placeholder: 'e.g. P01' });
  private count = h('select', { id: 'rounds' }, ...ROUNDS.map((n) => h('option', { value: String(n) }, `${n} rounds`)));
  private drawn = h('select', { id: 'order' }, h('option', { value: 'drawn' }, 'drawn every round'), h('option', { value: 'balanced' }, 'balanced, by the number in the name'));
  private practice = h('input', { id: 'practice', type: 'checkbox', checked: true });
  private guessed = false;  ///< in this round
  target = -1;
  get running(): boolean { return state.playing; }
  private set running(on: boolean) { state.playing = on; }
  onRound: (object: number) => void = () => {};  ///< -1: over
  onVerdict: (object: number, right: boolean) => void = () => {};

  constructor() {
    this.element = h('div', {}, this.body);
    this.idle();
  }

  scene(facts: ObjectFacts[]): void {
    const same = facts.length === this.facts.length && facts.every((f, i) => f.id === this.facts[i].id);
    this.facts = facts;
    if (!same && this.running) { this.leave(); announce('The scene has changed: the game is over.', true); }
    if (!same) this.idle();
  }

  private idle(): void {
    const enough = this.facts.length >= 2;
    fill(this.body,
      h('p', {}, 'One of the objects is hidden. Feel it, then say which it is. Force is heard as a tone: the harder, the higher and louder.'),
      h('label', { class: 'field' }, h('span', {}, 'Name'), this.participant),
      h('label', { class: 'field' }, h('span', {}, 'Rounds'), this.count),
      h('label', { class: 'field' }, h('span', {}, 'Objects'), this.drawn),
      h('label', { class: 'check' }, this.practice, h('span', {}, 'A practice round first, which does not count')),
      h('button', { class: 'primary', id: 'begin', disabled: !enough, onclick: () => this.begin() }, 'Begin'),
      !enough && h('p', { class: 'note' }, 'This needs two objects or more: open another mesh.'));
  }

  begin(): void {
    const number = this.drawn.value === 'balanced' ? Number(/\d+/.exec(this.participant.value)?.[0] ?? 0) : null;
    this.order = orderOf(this.facts.length, Number(this.count.value), number);
    if (this.practice.checked) this.order.unshift(Math.floor(Math.random() * this.facts.length));
    this.rounds = [];
    this.running = true;
    this.next();
  }

  private leave(): void { this.running = false; this.target = -1; this.onRound(-1); }
  private isPractice(round: number): boolean { return this.practice.checked && round === 0; }
  private titleOf(round: number): string { return this.isPractice(round) ? 'Practice' : `Round ${round + (this.practice.checked ? 0 : 1)} of ${this.order.length - (this.practice.checked ? 1 : 0)}`; }

  private next(): void {
    const i = this.rounds.length;
    if (i >= this.order.length) { this.finish(); return; }
    this.target = this.order[i];
    this.guessed = false;
    this.began = performance.now();
    this.servo = this.touched = this.path = this.contacts = 0;
    this.before = null;
    this.inContact = false;
    this.lastTime = -1;
    const names = this.facts.map((f, k) => h('label', { class: 'choice' }, h('input', { type: 'radio', name: 'guess', value: String(k) }), h('span', {}, f.name)));
    const confidence = h('select', { name: 'confidence', id: 'confidence' }, ...CONFIDENCE.map(([v, t]) => h('option', { value: v }, t)));
    const form = h('form', { onsubmit: (e: Event) => { e.preventDefault(); this.guess(form); } },
      h('fieldset', {}, h('legend', {}, `${this.titleOf(i)}: which object is it?`), ...names),
      h('label', { class: 'field' }, h('span', {}, 'How sure'), confidence),
      h('div', { class: 'row' }, h('button', { class: 'primary', type: 'submit' }, 'Guess'),
        h('button', { type: 'button', onclick: () => { this.leave(); this.idle(); } }, 'Leave the game')));
    this.body.replaceChildren(
      h('p', {}, 'Explore: drag over the empty stage, or focus it and use the arrow keys. Enter touches and lifts, Page Down presses harder, Q and E walk round, N says what is touched, Space stops.'),
      form);
    this.onRound(this.target);
    announce(`${this.titleOf(i)}. An object is hidden in the stage. Arrow keys move over it, Enter touches and lifts.`);
  }

  feel(frame: Frame): void {
    if (!this.running || this.guessed) return;
    const end = frame.time + (frame.ticks.length ? frame.ticks[frame.ticks.length - 1] : 0), passed = this.lastTime >= 0 && end > this.lastTime ? Math.min(end - this.lastTime, 0.5) : 0;
    this.lastTime = end;
    this.servo += passed;
    if (frame.contacts > 0) {
      this.touched += passed;
      if (this.before) this.path += Math.hypot(...frame.tool.map((x, i) => x - this.before![i]));
      this.before = frame.tool;
      if (!this.inContact) ++this.contacts;
    } else this.before = null;
    this.inContact = frame.contacts > 0;
  }

  private guess(form: HTMLFormElement): void {
    if (this.guessed) return;
    const data = new FormData(form), chosen = data.get('guess');
    if (chosen === null) { announce('Choose an object first.', true); return; }
    this.guessed = true;
    const guess = Number(chosen), right = guess === this.target, i = this.rounds.length;
    this.rounds.push({
      practice: this.isPractice(i), object: this.facts[this.target].name, guess: this.facts[guess].name, right, confidence: String(data.get('confidence') ?? ''), hash: this.facts[this.target].hash,
      seconds: (performance.now() - this.began) / 1000, servo_seconds: this.servo, touched_seconds: this.touched, path_m: this.path, contacts: this.contacts,
    });
    const words = right ? `✓ Right: it is ${this.facts[guess].name}.` : `✗ Wrong: it was ${this.facts[this.target].name}.`;
    const on = h('button', { class: 'primary', id: 'next', onclick: () => this.next() }, i + 1 < this.order.length ? 'Next round' : 'Result');
    this.body.replaceChildren(h('p', { class: `answer ${right ? 'good' : 'bad'}`, id: 'answer-words' }, words), h('p', { class: 'note' }, this.isPractice(i) ? 'That was practice: now it counts.' : 'Look at what you felt, then go on.'), h('div', { class: 'row' }, on));
    this.onVerdict(this.target, right);
    announce(words, true);
    on.focus();
  }

  private finish(): void {
    this.leave();
    const counted = this.rounds.filter((r) => !r.practice), right = counted.filter((r) => r.right).length, seconds = counted.reduce((s, r) => s + r.seconds, 0);
    const score = h('h3', { tabIndex: -1, id: 'score' }, `${right} of ${counted.length} right in ${seconds.toFixed(0)} s`);
    this.body.replaceChildren(score,
      h('table', {}, h('thead', {}, h('tr', {}, ...['Object', 'Guess', 'Sure', 'Time'].map((t) => h('th', { scope: 'col' }, t)))),
        h('tbody', {}, ...counted.map((r) => h('tr', {}, h('td', {}, r.object), h('td', {}, `${r.right ? '✓' : '✗'} ${r.guess}`), h('td', {}, r.confidence || '–'), h('td', {}, `${r.seconds.toFixed(1)} s`))))),
      h('div', { class: 'row' }, h('button', { class: 'primary', onclick: () => this.saveResults() }, 'Save results'), h('button', { onclick: () => this.begin() }, 'Again')));
    score.focus();
    announce(score.textContent ?? '');
  }

  results(): string {
    const head = 'participant,date,round,practice,object,hash,guess,right,confidence,seconds,servo_seconds,touched_seconds,path_m,contacts';
    // A leading = + - @ would be a formula in a spreadsheet.
    const cell = (s: string) => { const t = /^[=+\-@]/.test(s) ? `'${s}` : s; return /[",\n]/.test(t) ? `"${t.replaceAll('"', '""')}"` : t; };
    const date = new Date().toISOString();
    return [head, ...this.rounds.map((r, i) => [cell(this.participant.value), date, i + (this.practice.checked ? 0 : 1), Number(r.practice), cell(r.object), r.hash, cell(r.guess),
      Number(r.right), r.confidence, r.seconds.toFixed(2), r.servo_seconds.toFixed(3), r.touched_seconds.toFixed(3), r.path_m.toFixed(4), r.contacts].join(','))].join('\n') + '\n';
  }

  private saveResults(): void { save('recognition.csv', this.results(), 'text/csv'); }
}

export const game = new Recognise();
export const HIDDEN_HINT = 'Drag over this empty stage, or use the arrow keys: the object is here, unseen.';
export const gamePanel = h('div', {}, card('Recognise by touch', game.element), card('Senses', h('p', { class: 'note' }, 'Sound and spoken parts start with the game.'), h('div', { class: 'senses' })));

game.onRound = (object) => {
  const playing = object >= 0;
  hand.letGo();
  hand.only = object;
  world.objects.hidden = playing;
  hideTool();
  lookAt(-1);
  world.frame(playing ? object : -1);
  if (playing) { select(-1, -1); world.tool.mark(null); startSenses(); showHint(HIDDEN_HINT); openSheet(false); canvas.focus(); }
  else { sound.quiet(); hint.hidden = true; }
  changed('playing');
  void world.objects.paint();
};
game.onVerdict = (object, right) => {
  hand.letGo();
  hideTool();
  world.objects.hidden = false;  // what was felt is seen
  lookAt(object);
  hint.hidden = true;
  void world.objects.paint();
  sound.tap(right ? 880 : 180);
  if (right) setTimeout(() => sound.tap(1320), 130);
};
onFelt((frame) => game.feel(frame));
on(['scene'], () => game.scene(state.facts));
