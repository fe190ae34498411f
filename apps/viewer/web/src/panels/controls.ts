// Cards and fields, the same in every panel.
import { h } from '../dom';

export function card(title: string, ...children: (Node | string | false)[]): HTMLElement {
  return h('section', { class: 'card' }, h('h2', {}, title), ...children);
}
/// A card for settings that few need, closed at first.
export function folded(title: string, id: string, ...children: (Node | string | false)[]): HTMLDetailsElement {
  return h('details', { class: 'card folded', id }, h('summary', {}, title), ...children);
}
export function choice<T extends string>(
  label: string,
  values: [T, string][],
  value: T,
  change: (v: T) => void,
  id: string,
  title?: string,
): HTMLElement {
  const select = h(
    'select',
    { id, onchange: (e: Event) => change((e.target as HTMLSelectElement).value as T) },
    ...values.map(([v, text]) => h('option', { value: v }, text)),
  );
  select.value = value;
  return h('label', { class: 'field', title }, h('span', {}, label), select);
}
export function check(label: string, on: boolean, change: (on: boolean) => void, id: string, title?: string): HTMLElement {
  return h(
    'label',
    { class: 'check', title },
    h('input', { type: 'checkbox', checked: on, id, onchange: (e: Event) => change((e.target as HTMLInputElement).checked) }),
    h('span', {}, label),
  );
}
