// Force as sound, as speech and as rumble: one set of switches, in whichever panel is shown.
import { h } from '../dom';
import { Rumble, Sound, Voice } from '../senses';
import { check } from './controls';

export const sound = new Sound(),
  rumble = new Rumble(),
  voice = new Voice();

export const senses = h(
  'div',
  {},
  check(
    'Force as sound',
    false,
    (on) => {
      if (on) sound.start();
      else sound.stop();
    },
    'sound',
  ),
  check(
    'Say part and position',
    false,
    (on) => {
      voice.on = on;
      voice.forget();
    },
    'voice',
  ),
  check(
    'Rumble of a game pad',
    true,
    (on) => {
      rumble.on = on;
    },
    'rumble',
  ),
  h('p', { class: 'note', id: 'pads' }),
  h(
    'p',
    { class: 'note' },
    'On the stage, N says the touched part, the force and where the tool is. While it moves, a short tone is the higher the higher it is, left or right as it is.',
  ),
);
function showPads(): void {
  senses.querySelector('#pads')!.textContent = rumble.available()
    ? 'A game pad that rumbles is here.'
    : 'No game pad that rumbles was found: press one of its buttons.';
}
for (const type of ['gamepadconnected', 'gamepaddisconnected']) addEventListener(type, showPads);
showPads();

/// The switch of the sound in the header.
export const soundButton = h('button', {
  id: 'sound-button',
  title: 'Force as sound',
  onclick: () => {
    if (sound.on) sound.stop();
    else sound.start();
  },
});
sound.onSwitch = () => {
  soundButton.replaceChildren('♪', h('span', {}, sound.on ? ' Sound on' : ' Sound off'));
  soundButton.setAttribute('aria-pressed', String(sound.on));
  senses.querySelector<HTMLInputElement>('#sound')!.checked = sound.on;
};
sound.onSwitch();

/// Switches sound and speech on as a game begins.
export function startSenses(): void {
  if (!sound.on) sound.start();
  voice.on = true;
  for (const id of ['sound', 'voice']) senses.querySelector<HTMLInputElement>(`#${id}`)!.checked = true;
}
