// The program as the server that sent this page: a WebSocket for what both say, HTTP for what is fetched.
import type { Hears, Posted, Program } from './interface';

const token = new URLSearchParams(location.search).get('token') ?? '';
const address = (path: string): string => `${path}${path.includes('?') ? '&' : '?'}token=${token}`;

export class Server implements Program {
  readonly kind = 'server';
  private socket: WebSocket | null = null;
  private wait = 250;
  private told: 'opened' | 'lost' | 'stranger' | null = null;

  open(hears: Hears): void {
    const socket = new WebSocket(`ws://${location.host}${address('/ws')}`);
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    let opened = false;
    // The page hears of each change once, however often the connection is tried.
    const tell = (what: 'opened' | 'lost' | 'stranger') => {
      if (what === this.told) return;
      this.told = what;
      if (what === 'opened') hears.opened();
      else hears.lost(what === 'stranger');
    };
    socket.onopen = () => {
      opened = true;
      this.wait = 250;
      tell('opened');
    };
    socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer) hears.bytes(data);
      else hears.text(data as string);
    };
    socket.onclose = async () => {
      if (this.socket !== socket) return;
      // A new program refuses the token of the old one: the user has to read the new program's address.
      if (
        !opened &&
        (await fetch(address('/api/tool'), { method: 'HEAD' }).then(
          (r) => r.status,
          () => 0,
        )) === 403
      )
        tell('stranger');
      else tell('lost');
      setTimeout(() => this.open(hears), this.wait);
      this.wait = Math.min(2 * this.wait, 4000);
    };
  }

  say(text: string): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(text);
    return true;
  }

  get(path: string): Promise<Response> {
    return fetch(address(path)).catch(() => {
      throw new Error('The program does not answer.');
    });
  }

  post(path: string, file: Blob, sent: (share: number) => void, signal: AbortSignal): Promise<Posted> {
    return new Promise((resolve, reject) => {
      const request = new XMLHttpRequest();
      request.open('POST', address(path));
      request.upload.onprogress = (e) => {
        if (e.lengthComputable) sent(e.loaded / e.total);
      };
      request.onload = () => resolve({ status: request.status, text: request.responseText });
      request.onerror = () => reject(new Error('the program does not answer'));
      request.onabort = () => reject(new Error('cancelled'));
      signal.addEventListener('abort', () => request.abort());
      request.send(file);
    });
  }

  drop(): void {
    this.socket?.close();
  }
}
