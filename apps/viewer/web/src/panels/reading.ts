// How the models are read for the force: the layer, and what the paper's maps ask besides.
import { on, state } from '../state';
import { flag, number, pick } from './settings';

const layer = pick(
  'Layer',
  [
    ['tool', 'As the tool needs'],
    ['auto', 'Auto (tolerance)'],
    ['2', '2: base map'],
    ['3', '3: refined map'],
    ['gate', 'Gate k_L: 2 or 3'],
    ['exact', 'Exact triangles'],
  ],
  () => state.settings.layer,
  (v) => {
    state.settings.layer = v;
  },
  'layer',
);
const tolerance = number('Tolerance', 'mm', [0, 2, 0.05], 'tolerance', 1000);
const gate = number('Gate k_L', '', [0, 100, 1], 'gate', 1, false);
const force = pick(
  'Force',
  [
    ['full', 'Full'],
    ['paper', 'The paper’s'],
  ],
  () => (state.settings.paperForce ? 'paper' : 'full'),
  (v) => {
    state.settings.paperForce = v === 'paper';
    state.settings.law = v === 'paper' ? 'paper' : 'coulomb';
  },
  'force-law',
  'The paper’s: eqs. 21, 26 and 32',
);

// Objects with central maps pass over these.
const projector = pick(
  'Foot search',
  [
    ['newton', 'Newton'],
    ['pyramid', 'Pyramid, corrected'],
    ['printed', 'As printed'],
  ],
  () => state.settings.projector,
  (v) => {
    state.settings.projector = v;
  },
  'touch-projector',
  'Eqs. 15 to 19; as printed the depth is eq. 21’s',
);
const steps = number('Nearest steps', '', [0, 2, 1], 'nearestSteps', 1, false);
const gaps = flag('Openings behind the first surface', 'gaps', 'touch-gaps');
const pruning = flag('Parts prove points free', 'pruning', 'touch-pruning', 'Pruning of section 2');
const offset = flag('Offset', 'offset', 'touch-offset', 'Eq. 12, with the paper’s force');
const ofPaperMaps = [projector, steps, gaps, pruning, offset];

on(['status'], () => {
  const range = state.status?.nearestSteps,
    input = steps.querySelector('input')!;
  if (range) [input.min, input.max] = range.map(String);
});

export const readingRows = [layer, tolerance, gate, force, ...ofPaperMaps];

on(['settings', 'scene'], () => {
  const s = state.settings,
    others = state.facts.filter((_, i) => i !== s.tool); // the object in the hand does not count
  // As paper::idle_option has it: hidden where they change nothing.
  for (const row of ofPaperMaps) row.hidden = s.layer === 'exact' || others.every((f) => f.central);
  steps.hidden ||= s.layer === '2' || s.projector !== 'newton';
  gaps.hidden ||= s.layer === '2';
  offset.hidden ||= !s.paperForce;
  gate.hidden = s.layer !== 'gate';
  tolerance.hidden = s.layer !== 'auto';
  // Objects with central maps do not have the paper's force.
  force.querySelector<HTMLOptionElement>('option[value=paper]')!.disabled = others.some((f) => f.central);
});
