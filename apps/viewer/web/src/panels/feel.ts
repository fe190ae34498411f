// How a surface feels: material, stiffness, friction.
import { h } from '../dom';
import { MATERIALS, PLAIN } from '../materials';
import { pressBox } from '../press';
import { hand } from '../stage';
import { on, state } from '../state';
import { card, choice } from './controls';
import { sound } from './senses';
import { number, pick, slider, tellSettings } from './settings';
import { sweep } from './sweep';

const materialChoice = choice(
  'Material',
  [...Object.entries(MATERIALS).map(([key, m]) => [key, m.name] as [string, string]), ['', 'As set below']],
  'plain',
  (v) => {
    const m = MATERIALS[v];
    if (!m) return;
    const { stiffness, damping, friction, texture } = m;
    Object.assign(state.settings, { stiffness, damping, friction, texture, law: 'coulomb', paperForce: false });
    tellSettings();
  },
  'material',
);
materialChoice.querySelector<HTMLOptionElement>('option[value=""]')!.disabled = true; // the sliders choose it
/// Shows the material whose numbers are set; none where the user has changed them.
function showMaterial(): void {
  const s = state.settings,
    same = (key: 'stiffness' | 'friction' | 'texture' | 'damping', v: string) => Math.abs(s[key] - MATERIALS[v][key]) < 1e-9;
  const isOf = (v: string) => same('stiffness', v) && same('friction', v) && same('texture', v) && same('damping', v);
  const key = (s.law === 'coulomb' && Object.keys(MATERIALS).find(isOf)) || '';
  sound.material = MATERIALS[key] ?? PLAIN;
  const select = materialChoice.querySelector('select')!;
  if (document.activeElement !== select || key) select.value = key;
}

const press = slider(
  'Press',
  'mm',
  [-2, 20, 0.5],
  () => 1000 * hand.press,
  (x) => {
    hand.press = x / 1000;
    hand.deeper(0);
  },
);
const friction = number('Friction', '', [0, 1, 0.05], 'friction');
const printed = [
  number('f_c', 'N', [0, 1, 0.02], 'fC'),
  number('k_f', '1/m', [0, 500, 10], 'kF'),
  h('p', { class: 'note' }, 'f_c (1 + k_f depth) against the motion, whatever the load; none at rest.'),
];

export const feelCard = card(
  'Feel',
  materialChoice,
  press,
  pressBox,
  number('Stiffness', 'N/m', [50, 1500, 10], 'stiffness'),
  friction,
  ...printed,
  sweep.element,
);
export const lawChoice = pick(
  'Friction law',
  [
    ['coulomb', 'Coulomb'],
    ['paper', 'The paper’s'],
    ['none', 'None'],
  ],
  () => state.settings.law,
  (v) => {
    state.settings.law = v;
  },
  'law',
  'The paper’s: eq. 33',
);

on(['settings'], showMaterial);
on(['settings'], () => {
  friction.hidden = state.settings.law !== 'coulomb';
  for (const row of printed) row.hidden = state.settings.law !== 'paper';
});
