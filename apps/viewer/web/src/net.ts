// What the page and the program say to one another: JSON both ways, and a binary stream of what is felt.
import { meter } from './meter';
import { packed, program, saved } from './program/program';

export { packed, program, saved };

export interface Part {
  name: string; sphere: number[]; neighbours: number[]; triangles: number; area: number; certified: boolean; largestF: number | null;
  a: number[]; eps: number[]; taper: number[]; bend: number;
}
export interface ObjectFacts {
  name: string; hash: string; sphere: number[]; namesKept: boolean; edited: boolean; solid: boolean; triangles: number; vertices: number; hasTriangles: boolean;
  bytes: Record<string, number>; rMax: number; metresPerUnit: number; central: boolean; exact: boolean;
  position: number[]; half: number[]; measured: Record<string, number>; parts: Part[]; verdict: string; notes: string[]; cure: Cure | null;
  twin: number | null;  ///< the object of the same mesh and the other projection
  upload: number;  ///< this page's number of the file that it came from; 0: none
  id: number; revision: number; canUndo: boolean; canRedo: boolean;
}
export interface Settings {
  layer: string; tolerance: number; paperForce: boolean; proxy: boolean; stiffness: number; damping: number;
  law: string; friction: number; fC: number; kF: number; texture: number; smoothing: number;
  toolRadius: number; zone: number; forceLimit: number;
  tool: string | number; toolSize: number; toolTurn: number; toolTilt: number;
}
export interface Worn { garment: string; fabric: string; walks: boolean; pinned: number; number: number; seams: { name: string; sewn: boolean }[]; }
export interface DeviceRow { name: string; here: boolean; state: string; rate: number; limit: number; }
export interface Status {
  program: string;  ///< another one after every start
  touching: boolean; stopped: boolean; device: number; devices: DeviceRow[]; settings: Settings;
  cloth: { here: boolean; worn: Worn | null }; toolRevision: number;
  recorded?: number;  ///< ticks of a recording that the program keeps
  counters?: Record<string, number>; limit?: number; safeStiffness?: number; deviceName?: string;
}
export interface Frame {
  tool: number[]; hand: number[]; turn: number[]; force: number[]; torque: number[]; point: number[]; normal: number[];
  depth: number; contacts: number; object: number; part: number; acted: number; faults: number;
  late: number; degraded: boolean; engaged: boolean; connected: boolean;
  time: number;         ///< s of its first tick, by the servo's clock
  ticks: Float32Array;  ///< TICK numbers each: force, torque, depth, CPU time, s since the first
  recorded: number;  ///< ticks that the program has recorded, these included; 0: it does not
}
export interface ClothFrame {
  status: number; speed: number; stepMs: number; tension: number[]; body: number[]; fastest: number; contacts: number; gap: number; pinned: number;
  held: boolean; number: number;
  poses: Float32Array;      ///< 12 a bone: rows of the turn, shift
  positions: Float32Array;  ///< 3 a vertex
}
/// Contacts of the tool with an object, on the maps of its parts.
export interface Feet { object: number; feet: { part: number; x: number; y: number; depth: number }[]; }
export interface Cure { rung: string; input_to_result: Record<string, number>; result_to_input: Record<string, number>; made_up_share: number; }
/// upload: as of ObjectFacts.
export interface Progress { name: string; stage: string; done: number; upload: number; }

export interface Handlers {
  scene(objects: ObjectFacts[]): void;
  status(status: Status): void;
  frame(frame: Frame): void;
  cloth(frame: ClothFrame): void;
  feet(feet: Feet): void;
  progress(progress: Progress): void;
  trouble(text: string): void;
  connected(yes: boolean): void;
  /// Another program answers here, and this page does not have its token.
  stranger(): void;
  held(): void;   ///< another window has the tool
  taken(): void;  ///< another window took it from this one
}

const HEAD = 43, CLOTH_HEAD = 19;
export const TICK = 5;

export function readFrame(data: Float32Array): Frame {
  const v = (i: number) => [data[i], data[i + 1], data[i + 2]];
  return {
    tool: v(2), hand: v(38), time: data[41] + data[42], turn: Array.from(data.subarray(29, 38)), force: v(5), torque: v(8), point: v(11), normal: v(14),
    depth: data[17], contacts: data[18], object: data[19], part: data[20], acted: data[21], faults: data[22], late: data[23],
    degraded: data[24] > 0, engaged: data[25] > 0, connected: data[26] > 0, recorded: data[28], ticks: data.subarray(HEAD, HEAD + TICK * data[27]),
  };
}

/// What /api/recording/frames sends.
export function readFrames(data: ArrayBuffer): Frame[] {
  const count = new Uint32Array(data, 0, 2)[1], out: Frame[] = [];
  for (let at = 8; out.length < count;) {
    const length = new Uint32Array(data, at, 1)[0];
    out.push(readFrame(new Float32Array(data, at + 4, length)));
    at += 4 + 4 * length;
  }
  return out;
}

export function readCloth(data: Float32Array): ClothFrame {
  const vertices = data[2], bones = data[3], poses = CLOTH_HEAD + 12 * bones;
  return {
    status: data[4], speed: data[5], stepMs: data[6], tension: Array.from(data.subarray(7, 10)), fastest: data[10], contacts: data[11],
    gap: data[12], pinned: data[13], held: data[14] > 0, number: data[15], body: Array.from(data.subarray(16, 19)),
    poses: data.subarray(CLOTH_HEAD, poses), positions: data.subarray(poses, poses + 3 * vertices),
  };
}

export function readFeet(data: Float32Array): Feet {
  const feet = Array.from({ length: data[2] }, (_, i) => ({ part: data[3 + 4 * i], x: data[4 + 4 * i], y: data[5 + 4 * i], depth: data[6 + 4 * i] }));
  return { object: data[1], feet };
}

export class Link {
  open(handlers: Handlers): void {
    program.open({
      opened: () => handlers.connected(true),
      lost: (stranger) => { if (stranger) handlers.stranger(); else handlers.connected(false); },
      bytes(bytes) {
        const data = new Float32Array(bytes);
        meter.heard(bytes.byteLength, data[0] !== 3);
        meter.spend('message', () => { if (data[0] === 2) handlers.cloth(readCloth(data)); else if (data[0] === 3) handlers.feet(readFeet(data)); else handlers.frame(readFrame(data)); });
      },
      text(text) {
        const message = JSON.parse(text);
        if (message.say === 'scene') handlers.scene(message.objects);
        else if (message.say === 'status') handlers.status(message);
        else if (message.say === 'progress') handlers.progress(message);
        else if (message.say === 'trouble') handlers.trouble(message.text);
        else if (message.say === 'held') handlers.held();
        else if (message.say === 'taken') handlers.taken();
      },
    });
  }

  say(message: object): boolean { return program.say(JSON.stringify(message)); }

  /// For tests: as though the cable were pulled.
  drop(): void { program.drop(); }
}

export const link = new Link();

async function answerTo(path: string): Promise<Response> {
  const reply = await program.get(path);
  if (!reply.ok) throw new Error(`${path}: ${(await reply.text()).trim()}`);
  return reply;
}

export async function fetchBytes(path: string): Promise<ArrayBuffer> {
  return (await answerTo(path)).arrayBuffer();
}

export async function fetchJson<T>(path: string): Promise<T> {
  return (await answerTo(path)).json() as Promise<T>;
}

export interface Verdict {
  accepted: boolean; verdict: string; code?: string; element?: string; message?: string; cure?: string; notes?: string[]; triangles?: number;
}

/// How a file is read; empty: as it needs. upload: its number, by which it can be taken back.
export interface Reading { repair: string; thickness: string; unit: string; projection: string; upload: string; }

/// Sends a file; sent: share of it that is on its way, 0 to 1. reading: null for a recording.
export async function upload(file: File, reading: Reading | null, sent: (share: number) => void, signal: AbortSignal): Promise<Verdict> {
  const words = Object.entries({ name: file.name, ...reading }).filter(([, v]) => v !== '').map(([k, v]) => `${k}=${encodeURIComponent(v)}`);
  const { status, text } = await program.post(`/api/${reading ? 'upload' : 'recording'}?${words.join('&')}`, file, sent, signal);
  if (status === 413)
    return { accepted: false, verdict: 'REFUSED', code: 'E_LIMIT', element: 'file', message: text.trim(), cure: 'decimate the mesh, or bake it with the command line: sqmap bake' };
  try { return JSON.parse(text); } catch { throw new Error(text || `status ${status}`); }
}
