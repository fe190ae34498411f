// The program behind the page: the server that sent it, a worker of the page itself, or what a saved page kept of one.
import { Kept } from './kept';
import { Server } from './server';
import { hostedModels, InWorker } from './in_worker';
import type { ObjectFacts, Status } from '../net';

/// What the page hears of it.
export interface Hears {
  opened(): void;
  text(text: string): void;
  bytes(data: ArrayBuffer): void;
  /// It does not answer. stranger: another program answers instead, and this page does not have its token.
  lost(stranger: boolean): void;
}

/// How a POST went.
export interface Posted { status: number; text: string; }

export interface Program {
  readonly kind: 'server' | 'worker' | 'kept';
  /// Tries again and again where there is no answer.
  open(hears: Hears): void;
  /// False where nobody hears it.
  say(text: string): boolean;
  get(path: string): Promise<Response>;
  /// sent: share of the file that is on its way, 0 to 1. Rejects where the program does not answer or the signal ends it.
  post(path: string, file: Blob, sent: (share: number) => void, signal: AbortSignal): Promise<Posted>;
  /// For tests: as though the cable were pulled.
  drop(): void;
}

/// What a page saved as one file holds instead of the program: what it said last, bytes that it served, a recording.
export interface Saved { scene: ObjectFacts[]; status: Status; bytes: Record<string, string>; recording: string; pose: number[]; }
/// What a page holds that was saved where the program is a worker: the program itself, its files (models, names), a recording.
/// Bytes are base64.
export interface Packed { program: { worker: string; script: string; wasm: string }; files: [string, string][]; recording: string; pose: number[]; }
declare global { interface Window { sqmapSaved?: Saved; sqmapPacked?: Packed } }
export const saved = window.sqmapSaved, packed = window.sqmapPacked;

function bytesOf(base64: string): ArrayBuffer { return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)).buffer; }
function unpacked({ program: parts, files }: Packed): InWorker {
  // Not blobs: a page that is a file may start no worker from one. And no address may be as long as the program.
  const url = (text: string) => `data:text/javascript;base64,${text}`;
  return new InWorker(url(parts.worker), files.map(([name, text]) => [name, async () => bytesOf(text)]), { script: url(parts.script), wasm: bytesOf(parts.wasm) });
}

/// The script of the worker, where the page names one: it has no server then.
const { worker } = document.documentElement.dataset;

export const program: Program = saved ? new Kept(saved) : packed ? unpacked(packed) : worker ? new InWorker(worker, hostedModels()) : new Server();
