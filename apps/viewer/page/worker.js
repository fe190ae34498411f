// A worker that runs the viewer's program, compiled to WebAssembly, for the page that started it. Messages to it: {open} once the
// page listens, {text} that it says, {id, target, body} that it fetches or posts; from it: {ready}, {text}, {bytes},
// {id, status, type, body}, {broken}. In a page that is one file the first message to it is {parts}.
const waiting = [];
let program = null, told;
const parts = new Promise((resolve) => { told = resolve; });
self.onmessage = ({ data }) => { if (data.parts) told(data.parts); else if (program) take(data); else waiting.push(data); };

const FRAME = 1000 / 60;  // ms

/// Runs an action; an exception ends the program, and the page says so.
function guarded(action) {
  try { return action(); } catch (e) { self.postMessage({ broken: String(e?.message ?? e) }); throw e; }
}

/// Calls use with the address of bytes in the program's memory.
function within(bytes, use) {
  const at = program._malloc(bytes.length + 1);
  program.HEAPU8.set(bytes, at);
  program.HEAPU8[at + bytes.length] = 0;
  try { use(at); } finally { program._free(at); }
}
const encoder = new TextEncoder();

function take({ open, text, id, target, body }) {
  guarded(() => {
    if (open) program._page_open();
    else if (text !== undefined) within(encoder.encode(text), (at) => program._page_says(at));
    else within(encoder.encode(target), (where) => {
      if (!body) program._page_fetches(id, where, 0, 0);
      else within(new Uint8Array(body), (at) => program._page_fetches(id, where, at, body.byteLength));
    });
  });
  setTimeout(work);
}

/// One job at a time, so that the tool is heard in between.
function work() { if (guarded(() => program._page_work())) setTimeout(work); }

try {
  const { script, wasm } = self.location.protocol === 'data:' ? await parts : { script: './program.mjs' };
  const { default: load } = await import(script);
  const loaded = await load({
    ...(wasm ? { wasmBinary: wasm, locateFile: (name) => name } : {}),
    onText: (text) => self.postMessage({ text }),
    onBytes: ({ buffer }) => self.postMessage({ bytes: buffer }, [buffer]),
    onAnswer: (id, status, type, { buffer }) => self.postMessage({ id, status, type, body: buffer }, [buffer]),
  });
  program = loaded;
  self.postMessage({ ready: true });
  waiting.forEach(take);
  setInterval(() => { guarded(() => program._page_frame()); work(); }, FRAME);
} catch (e) {
  self.postMessage({ broken: String(e?.message ?? e) });
}
