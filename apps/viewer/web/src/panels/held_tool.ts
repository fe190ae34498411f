// The tool in the hand: a ball, a hand, or an object of the scene.
import { fill, h } from '../dom';
import { fetchBytes } from '../net';
import { trouble } from '../notices';
import { hand, world } from '../stage';
import { on, state } from '../state';
import { folded } from './controls';
import { flag, number, tellSettings } from './settings';

const toolSelect = h('select', {
  id: 'tool',
  onchange: () => {
    const v = toolSelect.value;
    state.settings.tool = v === 'ball' || v === 'hand' ? v : Number(v);
    hand.letGo();
    tellSettings();
  },
});
const ballRows = [
  number('Tool radius', 'mm', [2, 20, 0.5], 'toolRadius', 1000, false),
  number('Smoothing', 'mm', [0, 5, 0.25], 'smoothing', 1000, false),
];
const meshRows = [
  number('Tool size', 'mm', [10, 300, 5], 'toolSize', 1000, false),
  number('Turn', '°', [-180, 180, 15], 'toolTurn', 1, false),
  number('Tilt', '°', [-180, 180, 15], 'toolTilt', 1, false),
  flag('Its edges touch too', 'edges', 'touch-edges', 'Edges and faces between its points, where its surface is closed'),
];

export const toolCard = folded(
  'Tool',
  'more-tool',
  h('label', { class: 'field' }, h('span', {}, 'Tool'), toolSelect),
  ...ballRows,
  ...meshRows,
  number('Impact zone', 'mm', [0, 40, 1], 'zone', 1000, false),
  h(
    'p',
    { class: 'note' },
    'Smoothing above 0 makes the ball a point that feels with a sphere of that radius. An impact zone of 0 is the whole tool; a ball has none. A mesh is felt by its corners; one of the scene is not there to be touched while you hold it.',
  ),
);

function showSettings(): void {
  const s = state.settings;
  world.tool.setRadius(s.smoothing > 0 ? s.smoothing : s.toolRadius);
  for (const row of ballRows) row.hidden = s.tool !== 'ball';
  for (const row of meshRows) row.hidden = s.tool === 'ball';
  if (document.activeElement !== toolSelect) toolSelect.value = String(s.tool);
}
function showTools(): void {
  fill(
    toolSelect,
    h('option', { value: 'ball' }, 'Ball'),
    h('option', { value: 'hand' }, 'Hand'),
    ...state.facts.map((f, i) => (f.hasTriangles ? h('option', { value: String(i) }, `${f.name} (of the scene)`) : null)),
  );
  toolSelect.value = String(state.settings.tool);
}
on(['settings'], showSettings);
on(['scene'], showTools);

let shown = -1;
/// Draws the tool's newest mesh. revision: of the program's tool.
export async function fetchTool(revision: number): Promise<void> {
  if (revision === shown) return;
  shown = revision;
  const held = typeof state.settings.tool === 'number' ? state.settings.tool : -1;
  if (world.objects.inHand !== held) {
    world.objects.inHand = held;
    void world.objects.paint();
  }
  if (state.settings.tool === 'ball') {
    world.tool.setShape(null, null);
    return;
  }
  try {
    const data = await fetchBytes('/api/tool'),
      [, v, t] = new Uint32Array(data, 0, 3);
    if (revision === shown) world.tool.setShape(new Float32Array(data, 12, 3 * v), new Uint32Array(data, 12 + 12 * v, 3 * t));
  } catch (e) {
    shown = -1;
    trouble(e);
  }
}
/// Has the tool's mesh fetched again: the program may be another one.
export function forgetTool(): void {
  shown = -1;
}
