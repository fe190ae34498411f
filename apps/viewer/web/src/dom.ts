// Small helpers for the page's elements.

type Child = Node | string | null | undefined | false;
type Props = Record<string, unknown>;

/// An element: on… are listeners, class and other names attributes, known properties are set as such.
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  props: Props = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const e = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === false) continue;
    if (key.startsWith('on')) e.addEventListener(key.slice(2), value as EventListener);
    else if (key in e && !key.includes('-') && key !== 'list') (e as unknown as Props)[key] = value;
    else e.setAttribute(key === 'class' ? 'class' : key, value === true ? '' : String(value));
  }
  for (const c of children) if (c) e.append(c);
  return e;
}

/// An element of a drawing.
export function svg(tag: string, attributes: Record<string, string | number>, text = ''): SVGElement {
  const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) e.setAttribute(name, String(value));
  e.textContent = text;
  return e;
}

/// Replaces what the element held; what is not there is left out.
export function fill(e: Element, ...children: Child[]): void {
  e.replaceChildren(...children.filter((c): c is Node | string => !!c));
}

export function save(name: string, data: BlobPart, type: string): void {
  const url = URL.createObjectURL(new Blob([data], { type }));
  const a = h('a', { href: url, download: name });
  document.body.append(a);
  a.click();
  a.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

const live = h('div', { class: 'sr-only', 'aria-live': 'polite', id: 'live' });
const alertBox = h('div', { class: 'sr-only', role: 'alert', id: 'alert' });
document.body.append(live, alertBox);

/// Read out by a screen reader; the same words twice are read twice.
export function announce(text: string, urgent = false): void {
  const box = urgent ? alertBox : live;
  box.textContent = '';
  setTimeout(() => {
    box.textContent = text;
  }, 30);
}

export const bytes = (n: number): string => (n < 1e6 ? `${Math.round(n / 1e3)} kB` : `${(n / 1e6).toFixed(1)} MB`);
export const digits = (x: number, n = 3): string => (x === 0 ? '0' : Number(x.toPrecision(n)).toString());
/// The step between two lines of an axis from 0 to top: 1, 2 or 5 times a power of ten, such that so many lines fit.
export function stepOf(top: number, lines: number): number {
  const raw = top / lines,
    power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5, 10].find((k) => k * power >= raw) ?? 10);
}
