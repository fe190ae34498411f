// The page's two sides: the stage with its charts, and the panel.
import { h } from './dom';

export const panel = h('aside', { class: 'panel', id: 'panel', role: 'tabpanel' });
export const main = h('main', {});
