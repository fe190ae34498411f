// A game pad as the hand: the standard layout of the Gamepad API.
import { hand, world } from './stage';
import { stopButton } from './stop';
import { state } from './state';

const STILL = 0.16; // share of a stick's travel that is slack
const GLIDE = 0.7,
  TURN = 1.6; // at full travel: half heights of the stage a second, rad/s
const DEEPER = 0.008,
  NEARER = 1.2; // m/s of press; of the distance a second
const LONGEST = 0.1; // s, the longest time between two readings
const A = 0,
  B = 1,
  X = 2,
  LEFT = 4,
  RIGHT = 5,
  SOFTER = 6,
  HARDER = 7;

let last = 0,
  looks = false;
let before: boolean[] = [];

/// The travel of a stick without its slack, finer near the middle.
function travel(x: number): number {
  const beyond = Math.max(Math.abs(x) - STILL, 0) / (1 - STILL);
  return Math.sign(x) * beyond * beyond;
}

function take(pad: Gamepad, dt: number): void {
  const value = (button: number) => pad.buttons[button]?.value ?? 0,
    held = (button: number) => pad.buttons[button]?.pressed ?? false;
  const pressed = (button: number) => held(button) && !before[button];
  const [right, up, turn, tilt] = [
    travel(pad.axes[0] ?? 0),
    -travel(pad.axes[1] ?? 0),
    travel(pad.axes[2] ?? 0),
    travel(pad.axes[3] ?? 0),
  ];
  if (hand.enabled) {
    if (pressed(A)) hand.toggle();
    if (right || up) hand.moveBy(GLIDE * dt * right, GLIDE * dt * up);
    const press = value(HARDER) - value(SOFTER);
    if (Math.abs(press) > STILL && hand.holding) hand.deeper(DEEPER * dt * press);
    if (pressed(X)) hand.onAsk();
  }
  if (turn || tilt) world.turn(TURN * dt * turn, -TURN * dt * tilt);
  if (held(RIGHT) || held(LEFT)) world.zoom(Math.exp(NEARER * dt * (held(LEFT) ? 1 : -1)));
  if (pressed(B) && state.mode !== 'look') stopButton.click();
  before = pad.buttons.map((b) => b.pressed);
}

function look(now: number): void {
  const pad = Array.from(navigator.getGamepads()).find((p) => p?.mapping === 'standard');
  if (pad) take(pad, Math.min((now - last) / 1000, LONGEST));
  last = now;
  looks = Array.from(navigator.getGamepads()).some((p) => p);
  if (looks) requestAnimationFrame(look);
}
addEventListener('gamepadconnected', () => {
  if (!looks) {
    looks = true;
    last = performance.now();
    requestAnimationFrame(look);
  }
});
