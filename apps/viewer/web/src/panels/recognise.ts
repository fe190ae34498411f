// Recognising objects by touch alone: rounds with a hidden object, a guess, a score, and a file of results.
import { announce, fill, h, save } from '../dom';
import { hideTool, onFelt } from '../felt';
import type { Frame, ObjectFacts } from '../net';
import { canvas, hand, hint, showHint, world } from '../stage';
import { changed, on, state } from '../state';
import { card } from './controls';
import { select } from './parts';
import { sound, startSenses } from './senses';

interface Round { round: number; object: string; guess: string; right: boolean; hash: string; seconds: number; touched_seconds: number; path_m: number; contacts: number; }

export class Recognise {
  readonly element: HTMLElement;
  private body = h('div', {});
  private facts: ObjectFacts[] = [];
  private order: number[] = [];
  private rounds: Round[] = [];
  private began = 0;
  private touched = 0;
  private path = 0;
  private contacts = 0;
  private before: number[] | null = null;
  private inContact = false;
  private lastTime = 0;
  private participant = h('input', { id: 'participant', type: 'text', maxLength: 40, autocomplete: 'off', placeholder: 'e.g. P01' });
  private guessed = false;  ///< in this round
  target = -1;
  get running(): boolean { return state.playing; }
  private set running(on: boolean) { state.playing = on; }
  onRound: (object: number) => void = () => {};  ///< -1: over
  onSound: (good: boolean) => void = () => {};

  constructor() {
    this.element = h('div', {}, this.body);
    this.idle();
  }

  scene(facts: ObjectFacts[]): void {
    const same = facts.length === this.facts.length && facts.every((f, i) => f.id === this.facts[i].id);
    this.facts = facts;
    if (!same && this.running) { this.running = false; this.target = -1; this.onRound(-1); announce('The scene has changed: the game is over.', true); }
    if (!same) this.idle();
  }

  private idle(): void {
    const enough = this.facts.length >= 2;
    fill(this.body,
      h('p', {}, 'One of the objects is hidden. Feel it, then say which it is. Force is heard as a tone: the harder, the higher and louder.'),
      h('label', { for: 'participant' }, 'Name in the results (may stay empty)'), this.participant,
      h('button', { class: 'primary', id: 'begin', disabled: !enough, onclick: () => this.begin() }, 'Begin'),
      !enough && h('p', { class: 'note' }, 'This needs two objects or more: drop another mesh.'));
  }

  begin(): void {
    this.order = this.facts.map((_, i) => i);
    for (let i = this.order.length - 1; i > 0; --i) {
      const j = Math.floor(Math.random() * (i + 1));
      [this.order[i], this.order[j]] = [this.order[j], this.order[i]];
    }
    this.rounds = [];
    this.running = true;
    this.next();
  }

  private next(): void {
    const i = this.rounds.length;
    if (i >= this.order.length) { this.finish(); return; }
    this.target = this.order[i];
    this.guessed = false;
    this.began = performance.now();
    this.touched = this.path = this.contacts = 0;
    this.before = null;
    this.inContact = false;
    this.lastTime = this.began;
    const names = this.facts.map((f, k) => h('label', { class: 'choice' }, h('input', { type: 'radio', name: 'guess', value: String(k) }), h('span', {}, f.name)));
    const form = h('form', { onsubmit: (e: Event) => { e.preventDefault(); this.guess(form); } },
      h('fieldset', {}, h('legend', {}, `Round ${i + 1} of ${this.order.length}: which object is it?`), ...names),
      h('div', { class: 'row' }, h('button', { class: 'primary', type: 'submit' }, 'Guess'),
        h('button', { type: 'button', onclick: () => { this.running = false; this.target = -1; this.onRound(-1); this.idle(); } }, 'Leave the game')));
    this.body.replaceChildren(
      h('p', {}, 'Explore: drag over the empty stage, or focus it and use the arrow keys. Enter touches and lifts, Page Down presses harder, Q and E walk round, N says what is touched, Space stops.'),
      form);
    this.onRound(this.target);
    announce(`Round ${i + 1} of ${this.order.length}. An object is hidden in the stage. Arrow keys move over it, Enter touches and lifts.`);
  }

  feel(frame: Frame): void {
    if (!this.running) return;
    const now = performance.now();
    if (frame.contacts > 0) {
      this.touched += Math.min(now - this.lastTime, 100);
      if (this.before) this.path += Math.hypot(...frame.tool.map((x, i) => x - this.before![i]));
      this.before = frame.tool;
      if (!this.inContact) ++this.contacts;
    } else this.before = null;
    this.inContact = frame.contacts > 0;
    this.lastTime = now;
  }

  private guess(form: HTMLFormElement): void {
    if (this.guessed) return;
    const chosen = new FormData(form).get('guess');
    if (chosen === null) { announce('Choose an object first.', true); return; }
    this.guessed = true;
    form.querySelectorAll('button')[0].disabled = true;
    const guess = Number(chosen), right = guess === this.target;
    this.rounds.push({
      round: this.rounds.length + 1, object: this.facts[this.target].name, guess: this.facts[guess].name, right, hash: this.facts[this.target].hash,
      seconds: (performance.now() - this.began) / 1000, touched_seconds: this.touched / 1000, path_m: this.path, contacts: this.contacts,
    });
    this.onSound(right);
    announce(right ? `Right: ${this.facts[guess].name}.` : `Wrong: it was ${this.facts[this.target].name}.`, true);
    setTimeout(() => { if (this.running) this.next(); }, 900);
  }

  private finish(): void {
    this.running = false;
    this.target = -1;
    this.onRound(-1);
    const right = this.rounds.filter((r) => r.right).length, seconds = this.rounds.reduce((s, r) => s + r.seconds, 0);
    const score = h('h3', { tabIndex: -1, id: 'score' }, `${right} of ${this.rounds.length} right in ${seconds.toFixed(0)} s`);
    this.body.replaceChildren(score,
      h('table', {}, h('thead', {}, h('tr', {}, ...['Object', 'Guess', 'Verdict', 'Time'].map((t) => h('th', { scope: 'col' }, t)))),
        h('tbody', {}, ...this.rounds.map((r) => h('tr', {}, h('td', {}, r.object), h('td', {}, r.guess), h('td', {}, r.right ? '✓ right' : '✗ wrong'), h('td', {}, `${r.seconds.toFixed(1)} s`))))),
      h('div', { class: 'row' }, h('button', { class: 'primary', onclick: () => this.saveResults() }, 'Save results'), h('button', { onclick: () => this.begin() }, 'Again')));
    score.focus();
    announce(score.textContent ?? '');
  }

  results(): string {
    const head = 'participant,date,round,object,hash,guess,right,seconds,touched_seconds,path_m,contacts';
    // A leading = + - @ would be a formula in a spreadsheet.
    const cell = (s: string) => { const t = /^[=+\-@]/.test(s) ? `'${s}` : s; return /[",\n]/.test(t) ? `"${t.replaceAll('"', '""')}"` : t; };
    const date = new Date().toISOString();
    return [head, ...this.rounds.map((r) => [cell(this.participant.value), date, r.round, cell(r.object), r.hash, cell(r.guess),
      r.right ? 1 : 0, r.seconds.toFixed(2), r.touched_seconds.toFixed(2), r.path_m.toFixed(4), r.contacts].join(','))].join('\n') + '\n';
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
  world.frame(playing ? object : -1);
  if (playing) { select(-1, -1); world.tool.mark(null); startSenses(); showHint(HIDDEN_HINT); canvas.focus(); }
  else { sound.quiet(); hint.hidden = true; }
  changed('playing');
  void world.objects.paint();
};
game.onSound = (good) => { sound.tap(good ? 880 : 180); if (good) setTimeout(() => sound.tap(1320), 130); };
onFelt((frame) => game.feel(frame));
on(['scene'], () => game.scene(state.facts));
