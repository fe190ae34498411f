// The program as workers of this page, compiled to WebAssembly: any static host serves it. See apps/viewer/page. One worker has the
// scene and its forces; each dropped mesh is baked by another, so that touch goes on meanwhile and a bake can be ended.
import type { Hears, Posted, Program } from './interface';

const LARGEST = 64 * 1024 * 1024; // bytes of a file, as the server has it

interface Answer {
  id: number;
  status: number;
  type: string;
  body: ArrayBuffer;
}
type Message = { ready: true } | { text: string } | { bytes: ArrayBuffer } | { broken: string } | Answer;

/// The program's script and its WebAssembly, for a worker whose own script has no folder to load them from.
interface Parts {
  script: string;
  wasm: ArrayBuffer;
}

/// A worker and the requests that it has not answered.
class Thread {
  private worker: Worker;
  private waiting = new Map<number, (answer: Answer | null) => void>();
  private last = 0;
  runs = true;

  /// heard: gets messages that are no answers; ended: gets the reason where the worker fails.
  constructor(
    script: string,
    parts: Parts | null,
    heard: (message: Exclude<Message, Answer>) => void,
    ended: (why: string) => void,
  ) {
    this.worker = new Worker(new URL(script, document.baseURI), { type: 'module' });
    if (parts) this.worker.postMessage({ parts });
    this.worker.onerror = (e) => {
      this.end();
      ended(e.message || 'its script cannot be loaded');
    };
    this.worker.onmessage = ({ data }: MessageEvent<Message>) => {
      if ('id' in data) this.waiting.get(data.id)?.(data);
      else if ('broken' in data) {
        this.end();
        ended(data.broken);
      } else heard(data);
    };
  }

  tell(message: { open: true } | { text: string }): void {
    this.worker.postMessage(message);
  }

  ask(target: string, body?: ArrayBuffer): Promise<Answer> {
    return new Promise((resolve, reject) => {
      const id = ++this.last,
        gone = () => reject(new Error('the program in this page has ended, or was cancelled'));
      if (!this.runs) {
        gone();
        return;
      }
      this.waiting.set(id, (answer) => {
        this.waiting.delete(id);
        if (answer) resolve(answer);
        else gone();
      });
      this.worker.postMessage({ id, target, body }, body ? [body] : []);
    });
  }

  end(): void {
    this.runs = false;
    this.worker.terminate();
    for (const give of this.waiting.values()) give(null);
    this.waiting.clear();
  }
}

/// The name of a file, and a function that fetches its bytes.
type Source = [string, () => Promise<ArrayBuffer>];

/// The models of the host that the page begins with: those of ?model=, else those that the page's file names.
export function hostedModels(): Source[] {
  const named = new URLSearchParams(location.search).getAll('model');
  return (named.length ? named : (document.documentElement.dataset.models ?? '').split(' ').filter((name) => name)).map((model) => [
    model,
    async () => {
      const reply = await fetch(model);
      if (!reply.ok) throw new Error(`the host answers ${reply.status}`);
      return reply.arrayBuffer();
    },
  ]);
}

const textOf = ({ status, body }: Answer): Posted => ({ status, text: new TextDecoder().decode(body) });

export class InWorker implements Program {
  readonly kind = 'worker';
  private scene: Thread | null = null;
  private baking: Promise<unknown> = Promise.resolve();
  private hears!: Hears;

  /// files: the models and names that the page begins with.
  constructor(
    private script: string,
    private files: Source[],
    private parts: Parts | null = null,
  ) {}

  open(hears: Hears): void {
    this.hears = hears;
    this.scene = new Thread(
      this.script,
      this.parts,
      (message) => {
        if ('ready' in message) void this.begin();
        else if ('text' in message) hears.text(message.text);
        else if ('bytes' in message) hears.bytes(message.bytes);
      },
      (why) => this.lose(why),
    );
  }

  private note(message: object): void {
    this.hears.text(JSON.stringify(message));
  }

  private lose(why: string): void {
    this.scene?.end();
    this.hears.lost(false);
    this.note({ say: 'trouble', text: `The program in this page has ended: ${why}. Load the page again.` });
  }

  /// Adds the models that the page begins with, then opens the scene.
  private async begin(): Promise<void> {
    const failed: string[] = [];
    for (const [name, bytes] of this.files)
      try {
        await this.add(name.replace(/^.*\//, ''), await bytes());
      } catch (e) {
        failed.push(`${name}: ${e instanceof Error ? e.message : e}`);
      }
    this.hears.opened();
    this.scene!.tell({ open: true });
    for (const text of failed) this.note({ say: 'trouble', text });
  }

  /// Adds a model, or names of parts, to the scene.
  private async add(name: string, model: ArrayBuffer, upload = 0): Promise<void> {
    const verdict = JSON.parse(
      textOf(await this.scene!.ask(`/api/upload?name=${encodeURIComponent(name)}&upload=${upload}`, model)).text,
    );
    if (!verdict.accepted) throw new Error(`${verdict.message}; ${verdict.cure}`);
  }

  say(text: string): boolean {
    if (this.scene?.runs) this.scene.tell({ text });
    return this.scene?.runs ?? false;
  }

  async get(path: string): Promise<Response> {
    const { status, type, body } = await this.scene!.ask(path);
    return new Response(body, { status, headers: { 'Content-Type': type } });
  }

  async post(path: string, file: Blob, sent: (share: number) => void, signal: AbortSignal): Promise<Posted> {
    if (file.size > LARGEST) return { status: 413, text: `larger than ${LARGEST / 1024 / 1024} MB` };
    const body = await file.arrayBuffer(),
      name = new URLSearchParams(path.slice(path.indexOf('?'))).get('name') ?? '';
    sent(1);
    const upload = Number(new URLSearchParams(path.slice(path.indexOf('?'))).get('upload') ?? 0);
    if (/\.sqmap$|\.names\.json$|\.csv$/.test(name)) return textOf(await this.scene!.ask(path, body));
    await this.baking;
    if (signal.aborted) throw new Error('cancelled');
    return new Promise((resolve, reject) => {
      this.baking = this.bake({ path, upload, mesh: body, signal }, resolve).catch((e) => {
        reject(e);
        if (!signal.aborted) this.note({ say: 'trouble', text: `${name}: ${e instanceof Error ? e.message : e}` });
      });
    });
  }

  /// Bakes a mesh in a worker of its own. found: gets the verdict before the bake. Settles when the object is in the scene, or fails.
  private async bake(
    { path, upload, mesh, signal }: { path: string; upload: number; mesh: ArrayBuffer; signal: AbortSignal },
    found: (verdict: Posted) => void,
  ): Promise<void> {
    let name = '',
      done: () => void = () => {};
    const baked = new Promise<void>((resolve) => {
      done = resolve;
    });
    const fail = (why: string) => {
      this.note({ say: 'trouble', text: why });
      done();
    };
    const baker = new Thread(
      this.script,
      this.parts,
      (message) => {
        if (!('text' in message)) return;
        const said = JSON.parse(message.text);
        if (said.say === 'progress') this.hears.text(message.text);
        else if (said.say === 'trouble') fail(said.text);
        else if (said.say === 'scene' && said.objects.length) {
          name = said.objects[0].name;
          done();
        }
      },
      fail,
    );
    baker.tell({ open: true }); // before the mesh: it is heard from the first stage on
    signal.addEventListener('abort', () => {
      baker.end();
      done();
    });
    try {
      const verdict = textOf(await baker.ask(path, mesh));
      found(verdict);
      if (!JSON.parse(verdict.text).accepted) return;
      await baked;
      if (name && !signal.aborted) await this.add(`${name}.sqmap`, (await baker.ask('/api/object/0/sqmap')).body, upload);
      else this.note({ say: 'progress', name, stage: signal.aborted ? 'cancelled' : 'failed', done: 1, upload });
    } finally {
      baker.end();
    }
  }

  drop(): void {
    this.lose('it was stopped');
  }
}
