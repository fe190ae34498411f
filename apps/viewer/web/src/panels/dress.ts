// The figure and what it wears.
import { Costume } from '../costume';
import { h } from '../dom';
import { showTag } from '../felt';
import { link } from '../net';
import { canvas, hint, showHint, world } from '../stage';
import { on, state } from '../state';
import { onStop, whileFelt } from '../stop';
import { card } from './controls';

export const costume = new Costume(world, canvas, (message) => link.say(message));
export const dressPanel = h('div', {}, card('Costume', costume.element));

costume.onReady = () => {
  showHint('Press on the cloth and drag: it is pulled. Beside it the drag turns the view.');
  setTimeout(() => { if (state.mode === 'dress') hint.hidden = true; }, 6000);
};
onStop(() => costume.release());
costume.onPull = showTag;
costume.stopped = () => state.status?.stopped ?? false;
whileFelt(() => costume.held);
on(['status'], () => { if (state.status) costume.status(state.status); });
