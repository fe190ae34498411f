// A headset (WebXR): the objects stand before the user, and the tool is in a controller or at the tip of an index finger.
import * as THREE from 'three';
import { announce, h } from './dom';
import { link } from './net';
import { trouble } from './notices';
import { hand, world } from './stage';
import { state } from './state';
import { stopButton } from './stop';

const BEFORE = new THREE.Vector3(0, -0.2, -0.5); // m from the eyes to the middle of what is shown
const EYES = 1.55; // m above the floor
const PULSE = 60; // ms

export const immersiveButton = h('button', { id: 'immersive', hidden: true, onclick: () => void enter() }, 'Headset');

let session: XRSession | null = null;
let tool: XRInputSource | null = null; ///< the controller or hand that has the tool
let pose: number[] = [];
const target = new THREE.Vector3();

/// The position where the user wants the tool, in the world, m; null: the headset does not see the hand.
function pointOf(source: XRInputSource, frame: XRFrame, space: XRReferenceSpace): THREE.Vector3 | null {
  const tip = source.hand?.get('index-finger-tip');
  const at = tip ? frame.getJointPose?.(tip, space) : frame.getPose(source.targetRaySpace, space);
  return at ? target.copy(at.transform.position as unknown as THREE.Vector3).add(world.rig.position) : null;
}

function each(frame: XRFrame): void {
  const space = world.renderer!.xr.getReferenceSpace(),
    sources = [...(session?.inputSources ?? [])];
  if (!space) return;
  if (!tool || !sources.includes(tool)) tool = sources.find((s) => s.handedness === 'right') ?? sources[0] ?? null;
  const point = hand.enabled && tool && pointOf(tool, frame, space);
  if (point && !state.status?.stopped) hand.moveTo(point);
  else hand.letGo();
  const force = state.frame ? Math.hypot(...state.frame.force) : 0,
    motor = tool?.gamepad?.hapticActuators?.[0] as unknown as
      { pulse?(strength: number, ms: number): Promise<unknown> } | undefined;
  if (force > 0.05 && state.settings.forceLimit > 0)
    void motor?.pulse?.(Math.min(force / state.settings.forceLimit, 1), PULSE)?.catch(() => {});
}

function select(e: XRInputSourceEvent): void {
  if (state.status?.stopped) link.say({ say: 'resume' });
  if (e.inputSource !== tool) hand.letGo();
  tool = e.inputSource;
}

async function enter(): Promise<void> {
  const { renderer } = world;
  if (!renderer || session) {
    await session?.end();
    return;
  }
  try {
    session = await navigator.xr!.requestSession('immersive-vr', { optionalFeatures: ['local-floor', 'hand-tracking'] });
  } catch (e) {
    trouble(e);
    return;
  }
  pose = world.pose();
  session.addEventListener('end', leave);
  session.addEventListener('selectstart', select);
  session.addEventListener('squeezestart', () => stopButton.click());
  renderer.xr.enabled = true;
  const floor = await session.requestReferenceSpace('local-floor').catch(() => null);
  renderer.xr.setReferenceSpaceType(floor ? 'local-floor' : 'local');
  await renderer.xr.setSession(session);
  // The middle of the objects stands where BEFORE says.
  world.rig.position.copy(world.objects.box().getCenter(new THREE.Vector3())).sub(BEFORE).y -= floor ? EYES : 0;
  world.onImmersive = each;
  announce('In the headset: the tool is in your hand.');
}

function leave(): void {
  session = tool = null;
  world.onImmersive = () => {};
  hand.letGo();
  world.renderer!.xr.enabled = false;
  world.rig.position.set(0, 0, 0);
  world.setPose(pose);
  world.redraw();
}

void navigator.xr?.isSessionSupported('immersive-vr').then(
  (yes) => {
    immersiveButton.hidden = !yes || !world.renderer;
  },
  () => {},
);

/// For tests: the hand that has the tool.
export const immersive = () => (session ? (tool?.handedness ?? '') : null);
