// Reads the program's messages, JSON and a binary stream of frames, and hands each to its listener.
import type { ClothFrame, Feet, Frame, Progress, Reading, Scene, Status, Verdict } from './messages';
import { meter } from './meter';
import { packed, program, saved } from './program/program';

export { packed, program, saved };

interface Handlers {
  scene(scene: Scene): void;
  status(status: Status): void;
  frame(frame: Frame): void;
  cloth(frame: ClothFrame): void;
  feet(feet: Feet): void;
  progress(progress: Progress): void;
  trouble(text: string): void;
  connected(yes: boolean): void;
  /// Another program answers here, and this page does not have its token.
  stranger(): void;
  held(): void; ///< another window has the tool
  taken(): void; ///< another window took it from this one
}

const HEAD = 43,
  CLOTH_HEAD = 19;
export const TICK = 5;

function readFrame(data: Float32Array): Frame {
  const v = (i: number) => [data[i], data[i + 1], data[i + 2]];
  return {
    tool: v(2),
    hand: v(38),
    time: data[41] + data[42],
    turn: Array.from(data.subarray(29, 38)),
    force: v(5),
    torque: v(8),
    point: v(11),
    normal: v(14),
    depth: data[17],
    contacts: data[18],
    object: data[19],
    part: data[20],
    acted: data[21],
    faults: data[22],
    late: data[23],
    degraded: data[24] > 0,
    engaged: data[25] > 0,
    connected: data[26] > 0,
    recorded: data[28],
    ticks: data.subarray(HEAD, HEAD + TICK * data[27]),
  };
}

/// Reads the bytes of /api/recording/frames.
export function readFrames(data: ArrayBuffer): Frame[] {
  const count = new Uint32Array(data, 0, 2)[1],
    out: Frame[] = [];
  for (let at = 8; out.length < count;) {
    const length = new Uint32Array(data, at, 1)[0];
    out.push(readFrame(new Float32Array(data, at + 4, length)));
    at += 4 + 4 * length;
  }
  return out;
}

function readCloth(data: Float32Array): ClothFrame {
  const vertices = data[2],
    bones = data[3],
    poses = CLOTH_HEAD + 12 * bones;
  return {
    status: data[4],
    speed: data[5],
    stepMs: data[6],
    tension: Array.from(data.subarray(7, 10)),
    fastest: data[10],
    contacts: data[11],
    gap: data[12],
    pinned: data[13],
    held: data[14] > 0,
    number: data[15],
    body: Array.from(data.subarray(16, 19)),
    poses: data.subarray(CLOTH_HEAD, poses),
    positions: data.subarray(poses, poses + 3 * vertices),
  };
}

function readFeet(data: Float32Array): Feet {
  const feet = Array.from({ length: data[2] }, (_, i) => ({
    part: data[3 + 4 * i],
    x: data[4 + 4 * i],
    y: data[5 + 4 * i],
    depth: data[6 + 4 * i],
  }));
  return { object: data[1], feet };
}

export class Link {
  open(handlers: Handlers): void {
    program.open({
      opened: () => handlers.connected(true),
      lost: (stranger) => {
        if (stranger) handlers.stranger();
        else handlers.connected(false);
      },
      bytes(bytes) {
        const data = new Float32Array(bytes);
        meter.heard(bytes.byteLength, data[0] !== 3);
        meter.spend('message', () => {
          if (data[0] === 2) handlers.cloth(readCloth(data));
          else if (data[0] === 3) handlers.feet(readFeet(data));
          else handlers.frame(readFrame(data));
        });
      },
      text(text) {
        const message = JSON.parse(text);
        if (message.say === 'scene')
          handlers.scene({ objects: message.objects, loading: message.loading ?? 0, removed: message.removed ?? null });
        else if (message.say === 'status') handlers.status(message);
        else if (message.say === 'progress') handlers.progress(message);
        else if (message.say === 'trouble') handlers.trouble(message.text);
        else if (message.say === 'held') handlers.held();
        else if (message.say === 'taken') handlers.taken();
      },
    });
  }

  say(message: object): boolean {
    return program.say(JSON.stringify(message));
  }

  /// For tests: loses the connection.
  drop(): void {
    program.drop();
  }
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

/// Sends a file. sent: gets the share that is on its way, 0 to 1. reading: null for a recording.
export async function upload(
  file: File,
  reading: Reading | null,
  sent: (share: number) => void,
  signal: AbortSignal,
): Promise<Verdict> {
  const words = Object.entries({ name: file.name, ...reading })
    .filter(([, v]) => v !== '')
    .map(([k, v]) => `${k}=${encodeURIComponent(v)}`);
  const { status, text } = await program.post(`/api/${reading ? 'upload' : 'recording'}?${words.join('&')}`, file, sent, signal);
  if (status === 413)
    return {
      accepted: false,
      verdict: 'REFUSED',
      code: 'E_LIMIT',
      element: 'file',
      message: text.trim(),
      cure: 'decimate the mesh, or bake it with the command line: sqmap bake',
    };
  try {
    return JSON.parse(text);
  } catch {
    throw new Error(text || `status ${status}`);
  }
}
