// Fields of the settings of touch: each shows one setting, changes it and reports the change to the program.
import { digits, h } from '../dom';
import type { Settings } from '../messages';
import { link } from '../net';
import { changed, on, state } from '../state';
import { check, choice } from './controls';

type Keys<T> = { [K in keyof Settings]: Settings[K] extends T ? K : never }[keyof Settings];

/// range: least, greatest, step. live: the value is set while the slider moves, and not when it is let go.
export function slider(
  label: string,
  unit: string,
  range: [number, number, number],
  get: () => number,
  set: (x: number) => void,
  live = true,
): HTMLElement {
  const id = `s-${label.toLowerCase().replace(/[^a-z]+/g, '-')}`;
  const read = h('output', { for: id }),
    input = h('input', { type: 'range', id, min: String(range[0]), max: String(range[1]), step: String(range[2]) });
  const show = () => {
    read.textContent = `${digits(Number(input.value), 4)} ${unit}`;
    input.setAttribute('aria-valuetext', read.textContent);
  };
  input.addEventListener('input', () => {
    show();
    if (live) set(Number(input.value));
  });
  if (!live) input.addEventListener('change', () => set(Number(input.value)));
  on(['settings'], () => {
    if (document.activeElement !== input) input.value = String(get());
    show();
  });
  return h('label', { class: 'field slider' }, h('span', {}, label), input, read);
}
/// A slider of a number that the program knows: the slider shows `scale` times the setting.
export function number(
  label: string,
  unit: string,
  range: [number, number, number],
  key: Keys<number>,
  scale = 1,
  live = true,
): HTMLElement {
  const set = (x: number) => {
    (state.settings[key] as number) = x / scale;
    tellSettings();
  };
  return slider(label, unit, range, () => scale * (state.settings[key] as number), set, live);
}
/// A box to check, for a setting that is on or off.
export function flag(label: string, key: Keys<boolean>, id: string, title?: string): HTMLElement {
  const set = (value: boolean) => {
    state.settings[key] = value;
    tellSettings();
  };
  const field = check(label, state.settings[key], set, id, title);
  const box = field.querySelector('input')!;
  on(['settings'], () => {
    if (document.activeElement !== box) box.checked = state.settings[key];
  });
  return field;
}
/// One of several values. get and set: in words of the choice.
export function pick(
  label: string,
  values: [string, string][],
  get: () => string,
  set: (v: string) => void,
  id: string,
  title?: string,
): HTMLElement {
  const take = (v: string) => {
    set(v);
    tellSettings();
  };
  const field = choice(label, values, values[0][0], take, id, title);
  const select = field.querySelector('select')!;
  on(['settings'], () => {
    if (document.activeElement !== select) select.value = get();
  });
  return field;
}

let tellDue = 0,
  heardDue = 0,
  lastChange = -1e9;
/// Tells the program of the settings, at most once in 40 ms.
export function tellSettings(): void {
  lastChange = performance.now();
  clearTimeout(tellDue);
  changed('settings');
  tellDue = window.setTimeout(() => {
    tellDue = 0;
    lastChange = performance.now();
    link.say({ say: 'settings', ...state.settings });
  }, 40);
}
/// Takes the settings that the program has over, but for one that is being changed here: that is newer than the program's.
export function hearSettings(settings: Settings): void {
  clearTimeout(heardDue);
  if (!tellDue && performance.now() - lastChange > 400) state.settings = { ...settings };
  else heardDue = window.setTimeout(() => changed('status'), 500);
  changed('settings');
}
