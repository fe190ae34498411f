// A page in one file without the program, which answers from the last messages of one.
import type { Hears, Posted, Program, Saved } from './interface';

const GONE = 'This needs the program: it is not in the saved page.';

export class Kept implements Program {
  readonly kind = 'kept';
  constructor(private saved: Saved) {}

  open(hears: Hears): void {
    const { scene, status } = this.saved;
    setTimeout(() => {
      hears.opened();
      for (const message of [
        { say: 'scene', objects: scene },
        { ...status, say: 'status' },
      ])
        hears.text(JSON.stringify(message));
    });
  }

  say(): boolean {
    return false;
  }

  async get(path: string): Promise<Response> {
    const text = this.saved.bytes[path];
    if (text === undefined) throw new Error(GONE);
    return fetch(`data:application/octet-stream;base64,${text}`);
  }

  post(): Promise<Posted> {
    return Promise.reject(new Error(GONE));
  }
  drop(): void {}
}
