// The connection to the program: JSON both ways, and a binary stream of what is felt.
import { meter } from './meter';

export interface Part {
  name: string; sphere: number[]; neighbours: number[]; triangles: number; area: number; certified: boolean; largestF: number | null;
  a: number[]; eps: number[]; taper: number[]; bend: number;
}
export interface ObjectFacts {
  name: string; hash: string; sphere: number[]; namesKept: boolean; edited: boolean; solid: boolean; triangles: number; vertices: number; hasTriangles: boolean;
  bytes: Record<string, number>; rMax: number; metresPerUnit: number; central: boolean; exact: boolean;
  position: number[]; half: number[]; measured: Record<string, number>; parts: Part[]; verdict: string; notes: string[]; cure: Cure | null;
  twin: number | null;  ///< the object of the same mesh and the other projection
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
export interface Progress { name: string; stage: string; done: number; }

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

/// What a page saved as one file holds instead of the program: what it said last, bytes that it served, a recording.
export interface Saved { scene: ObjectFacts[]; status: Status; bytes: Record<string, string>; recording: string; pose: number[]; }
declare global { interface Window { sqmapSaved?: Saved } }
export const saved = window.sqmapSaved;

const token = new URLSearchParams(location.search).get('token') ?? '';
export const address = (path: string): string => `${path}${path.includes('?') ? '&' : '?'}token=${token}`;

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
  private socket: WebSocket | null = null;
  private wait = 250;
  private handlers!: Handlers;

  /// Tries again and again where there is no answer.
  open(handlers: Handlers): void {
    this.handlers = handlers;
    if (!saved) { this.connect(); return; }
    setTimeout(() => { handlers.connected(true); handlers.scene(saved.scene); handlers.status(saved.status); });
  }

  private connect(): void {
    const socket = new WebSocket(`ws://${location.host}${address('/ws')}`);
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    let opened = false;
    socket.onopen = () => { opened = true; this.wait = 250; this.handlers.connected(true); };
    socket.onmessage = (event) => {
      if (event.data instanceof ArrayBuffer) {
        const data = new Float32Array(event.data);
        meter.heard(event.data.byteLength, data[0] !== 3);
        meter.spend('message', () => { if (data[0] === 2) this.handlers.cloth(readCloth(data)); else if (data[0] === 3) this.handlers.feet(readFeet(data)); else this.handlers.frame(readFrame(data)); });
        return;
      }
      const message = JSON.parse(event.data as string);
      if (message.say === 'scene') this.handlers.scene(message.objects);
      else if (message.say === 'status') this.handlers.status(message);
      else if (message.say === 'progress') this.handlers.progress(message);
      else if (message.say === 'trouble') this.handlers.trouble(message.text);
      else if (message.say === 'held') this.handlers.held();
      else if (message.say === 'taken') this.handlers.taken();
    };
    socket.onclose = async () => {
      if (this.socket !== socket) return;
      this.handlers.connected(false);
      // Refused: only who has read the new program's address may go on.
      if (!opened && (await fetch(address('/api/tool'), { method: 'HEAD' }).then((r) => r.status, () => 0)) === 403) this.handlers.stranger();
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, 4000);
    };
  }

  say(message: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /// For tests: as though the cable were pulled.
  drop(): void { this.socket?.close(); }
}

export const link = new Link();

async function answerTo(path: string): Promise<Response> {
  if (saved) {
    const text = saved.bytes[path];
    if (text === undefined) throw new Error('This needs the program: it is not in the saved page.');
    return fetch(`data:application/octet-stream;base64,${text}`);
  }
  let reply;
  try { reply = await fetch(address(path)); } catch { throw new Error('The program does not answer.'); }
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

/// How a file is read; empty: as it needs.
export interface Reading { repair: string; thickness: string; unit: string; projection: string; }

/// Sends a file; sent: share of it that is on its way, 0 to 1.
export function upload(file: File, reading: Reading, sent: (share: number) => void, signal: AbortSignal): Promise<Verdict> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(), words = Object.entries({ name: file.name, ...reading }).filter(([, v]) => v !== '').map(([k, v]) => `${k}=${encodeURIComponent(v)}`);
    request.open('POST', address(`/api/upload?${words.join('&')}`));
    request.upload.onprogress = (e) => { if (e.lengthComputable) sent(e.loaded / e.total); };
    request.onload = () => {
      if (request.status === 413) {
        resolve({ accepted: false, verdict: 'REFUSED', code: 'E_LIMIT', element: 'file', message: request.responseText.trim(),
          cure: 'decimate the mesh, or bake it with the command line: sqmap bake' });
        return;
      }
      try { resolve(JSON.parse(request.responseText)); } catch { reject(new Error(request.responseText || `status ${request.status}`)); }
    };
    request.onerror = () => reject(new Error('the program does not answer'));
    request.onabort = () => reject(new Error('cancelled'));
    signal.addEventListener('abort', () => request.abort());
    request.send(file);
  });
}
