// The state that more than one panel reads: the program's newest messages, and the user's choices. Code that changes the state calls
// changed(), and listeners draw the change.
import type { Frame, ObjectFacts, Settings, Status } from './messages';
import type { Hit } from './objects';

export type Mode = 'look' | 'touch' | 'recognise' | 'dress';
export const MODES: Mode[] = ['touch', 'look', 'recognise', 'dress'];

export interface State {
  mode: Mode;
  facts: ObjectFacts[];
  loading: number; ///< objects that are still to come
  removed: string | null; ///< the name of the object that can be taken back
  status: Status | null;
  selected: { object: number; part: number } | null;
  pick: Hit | null; ///< the point that was clicked
  settings: Settings; ///< zeros until the program has sent its own
  frame: Frame | null; ///< the newest
  frames: number; ///< since the page was opened
  touched: number; ///< the object that the tool touched last; -1: none
  playing: boolean; ///< a round of recognition is under way: objects are hidden and not named
}

export const state: State = {
  mode: 'touch',
  facts: [],
  loading: 0,
  removed: null,
  status: null,
  selected: null,
  pick: null,
  settings: {
    layer: 'tool',
    tolerance: 0,
    paperForce: false,
    proxy: true,
    stiffness: 0,
    damping: 0,
    law: 'coulomb',
    friction: 0,
    fC: 0,
    kF: 0,
    texture: 0,
    smoothing: 0,
    toolRadius: 0.006,
    zone: 0,
    forceLimit: 0,
    projector: 'newton',
    nearestSteps: 2,
    gaps: true,
    pruning: true,
    gate: 10,
    offset: false,
    tool: 'ball',
    toolSize: 0,
    toolTurn: 0,
    toolTilt: 0,
    edges: false,
  },
  frame: null,
  frames: 0,
  touched: -1,
  playing: false,
};

/// mode: another panel is shown; scene: facts; status: the program's; settings: changed here, or heard of; selected; pick; playing; touched: another object; focus:
/// another object is large, the others pale.
type Change = 'mode' | 'scene' | 'status' | 'settings' | 'selected' | 'pick' | 'playing' | 'touched' | 'focus';
const listeners: Record<Change, (() => void)[]> = {
  mode: [],
  scene: [],
  status: [],
  settings: [],
  selected: [],
  pick: [],
  playing: [],
  touched: [],
  focus: [],
};

export function on(changes: Change[], listener: () => void): void {
  for (const change of changes) listeners[change].push(listener);
}
export function changed(change: Change): void {
  for (const listener of listeners[change]) listener();
}
