// What stands behind the page, as the page sees it, and what a page in one file holds of it.
import type { ObjectFacts, Status } from '../messages';

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
