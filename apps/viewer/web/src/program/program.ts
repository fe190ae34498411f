// The program behind the page: the server that sent it, a worker of the page itself, or what a saved page kept of one.
import { Kept } from './kept';
import { Server } from './server';
import { hostedModels, InWorker } from './in_worker';
import type { Packed, Program, Saved } from './interface';

declare global {
  interface Window {
    sqmapSaved?: Saved;
    sqmapPacked?: Packed;
  }
}
export const saved = window.sqmapSaved,
  packed = window.sqmapPacked;

function bytesOf(base64: string): ArrayBuffer {
  return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)).buffer;
}
function unpacked({ program: parts, files }: Packed): InWorker {
  // A page that is a file can start no worker from a blob, and no address can be as long as the program: the scripts are data
  // addresses, and the worker gets the program by message.
  const url = (text: string) => `data:text/javascript;base64,${text}`;
  return new InWorker(
    url(parts.worker),
    files.map(([name, text]) => [name, async () => bytesOf(text)]),
    { script: url(parts.script), wasm: bytesOf(parts.wasm) },
  );
}

/// The script of the worker, where the page names one; the page then has no server.
const { worker } = document.documentElement.dataset;

export const program: Program = saved
  ? new Kept(saved)
  : packed
    ? unpacked(packed)
    : worker
      ? new InWorker(worker, hostedModels())
      : new Server();
