// The program behind the page as the page sees it, and the content of pages in one file.
import type { ObjectFacts, Status } from '../messages';

/// Receives what the program sends.
export interface Hears {
  opened(): void;
  text(text: string): void;
  bytes(data: ArrayBuffer): void;
  /// The program does not answer. stranger: another program answers instead, and this page does not have its token.
  lost(stranger: boolean): void;
}

/// The answer to a POST.
export interface Posted {
  status: number;
  text: string;
}

export interface Program {
  readonly kind: 'server' | 'worker' | 'kept';
  /// Connects, and tries again and again where there is no answer.
  open(hears: Hears): void;
  /// Sends a message; false where there is no connection.
  say(text: string): boolean;
  get(path: string): Promise<Response>;
  /// Sends a file. sent: gets the share that is on its way, 0 to 1. Rejects where the program does not answer or the signal aborts.
  post(path: string, file: Blob, sent: (share: number) => void, signal: AbortSignal): Promise<Posted>;
  /// For tests: loses the connection.
  drop(): void;
}

/// The content of a page in one file without the program: its last messages, bytes that it served, a recording.
export interface Saved {
  scene: ObjectFacts[];
  status: Status;
  bytes: Record<string, string>;
  recording: string;
  view: unknown;
}
/// The content of a page in one file with the program, saved where that is a worker: the program, files (models, names), a recording.
/// Bytes are base64.
export interface Packed {
  program: { worker: string; script: string; wasm: string };
  files: [string, string][];
  recording: string;
  view: unknown;
}
