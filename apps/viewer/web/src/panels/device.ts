// The haptic device: which one, its rate and limit, and how the servo loop keeps its time.
import { digits, fill, h } from '../dom';
import { link, program } from '../net';
import { on, state } from '../state';
import { folded } from './controls';

const deviceSelect = h('select', { id: 'device', onchange: () => link.say({ say: 'device', device: Number(deviceSelect.value) }) });
const deviceTable = h('tbody', { id: 'devices' });
const deviceFacts = h('p', { class: 'note', id: 'device-facts' });
export const counters = h('p', { class: 'note', id: 'counters' });

export const deviceCard = folded(
  'Device',
  'more-device',
  h('label', { class: 'field' }, h('span', {}, 'Device'), deviceSelect),
  deviceFacts,
  h(
    'details',
    { id: 'device-list' },
    h('summary', {}, 'All devices'),
    h(
      'table',
      {},
      h('thead', {}, h('tr', {}, ...['Device', 'State', 'Rate', 'Limit'].map((t) => h('th', { scope: 'col' }, t)))),
      deviceTable,
    ),
  ),
);

function showDevices(): void {
  const devices = state.status?.devices ?? [];
  if (!devices.length || deviceSelect.childElementCount === devices.length) return;
  const cells = (...texts: string[]) => h('tr', {}, ...texts.map((t) => h('td', {}, t)));
  fill(
    deviceTable,
    ...devices.map((d) =>
      cells(
        d.name,
        `${d.here ? '✓' : '–'} ${d.state}`,
        d.rate > 0 ? `${d.rate} Hz` : '–',
        d.limit > 0 ? `${digits(d.limit)} N` : '–',
      ),
    ),
  );
  deviceSelect.replaceChildren(
    ...devices.map((d, i) => h('option', { value: String(i), disabled: !d.here }, d.here ? d.name : `${d.name} (not here)`)),
  );
}
on(['status'], () => {
  const s = state.status;
  if (!s) return;
  showDevices();
  deviceSelect.value = String(s.device);
  const d = s.devices[s.device];
  deviceFacts.textContent = d
    ? `${d.state}. ${d.rate} Hz, at most ${digits(s.limit ?? d.limit)} N.${s.safeStiffness && s.safeStiffness < state.settings.stiffness ? ` Stiffer than this device is proven stable with (${digits(s.safeStiffness)} N/m).` : ''}`
    : '';
  if (program.kind === 'worker')
    deviceFacts.append(' A page without the program reaches no haptic device and dresses no figure: sqmap view does.');
  const c = s.counters;
  counters.textContent = c
    ? `Servo: ${c.ticks.toLocaleString('en')} ticks; ${c.late} late, ${c.missed} missed, ${c.overruns} over budget, worst ${c.worstLate.toFixed(1)} ms late.`
    : 'The servo starts with the first touch.';
});
