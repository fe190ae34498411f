// Light, dark and high contrast.
import { announce, h } from './dom';

const dark = matchMedia('(prefers-color-scheme: dark)'),
  contrast = matchMedia('(prefers-contrast: more)');
export const THEMES = ['light', 'dark', 'contrast'];
const THEME_NAMES: Record<string, string> = { light: 'Light', dark: 'Dark', contrast: 'High contrast' };
const themeNow = (): string =>
  document.documentElement.dataset.theme ?? (contrast.matches ? 'contrast' : dark.matches ? 'dark' : 'light');
export const themeButton = h(
  'button',
  {
    class: 'quiet',
    id: 'theme',
    title: 'Light, dark, high contrast',
    onclick: () => {
      setTheme(THEMES[(THEMES.indexOf(themeNow()) + 1) % THEMES.length]);
      announce(`${THEME_NAMES[themeNow()]}.`);
    },
  },
  '◐',
);
export function setTheme(name: string): void {
  document.documentElement.dataset.theme = name;
  applyTheme();
}
for (const m of [dark, contrast]) m.addEventListener('change', applyTheme);

/// Functions that draw in the theme's colours.
const painters: (() => void)[] = [];
export function onTheme(paint: () => void): void {
  painters.push(paint);
}
export function applyTheme(): void {
  if (contrast.matches && !document.documentElement.dataset.theme) document.documentElement.dataset.theme = 'contrast';
  themeButton.setAttribute('aria-label', `Colours: ${THEME_NAMES[themeNow()]}`);
  for (const paint of painters) paint();
}
