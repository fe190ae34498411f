// The page as one file that needs no program: its script and style, the objects, the view, and the recording where there is one.
import { h, save } from '../dom';
import { fetchBytes, packed, program, saved } from '../net';
import { trouble, wait } from '../notices';
import type { Packed, Saved } from '../program/interface';
import { tabs } from '../modes';
import { hand, showHint, world } from '../stage';
import { showView, viewNow } from '../session';
import { on, state, type Mode } from '../state';
import { lookPanel } from './look';
import { openRecording, recorder, recordingCard } from './recording';
import { touchPanel } from './touch';

function base64(data: ArrayBuffer): string {
  const bytes = new Uint8Array(data),
    pieces: string[] = [];
  for (let i = 0; i < bytes.length; i += 0x8000) pieces.push(String.fromCharCode(...bytes.subarray(i, i + 0x8000)));
  return btoa(pieces.join(''));
}

/// Escapes the texts that would end a script element.
const inScript = (text: string): string => text.replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');

/// The program's messages and bytes that a page needs for looking and replaying.
async function said(): Promise<Saved> {
  const bytes: Saved['bytes'] = {};
  const shown = world.objects.colourBy,
    fields = [...new Set(['error', ...(shown === 'parts' ? [] : [shown])])];
  for (const [i, f] of state.facts.entries())
    for (const what of [
      'mesh',
      'superquadrics',
      ...fields.filter((kind) => kind !== 'difference' || f.twin !== null).map((kind) => `field/${kind}`),
    ])
      bytes[`/api/object/${i}/${what}`] = base64(await fetchBytes(`/api/object/${i}/${what}`));
  const status = {
    ...state.status!,
    touching: false,
    stopped: false,
    recorded: 0,
    devices: [],
    device: 0,
    counters: undefined,
    cloth: { here: false, worn: null },
    settings: { ...state.settings, tool: 'ball' },
  };
  return { scene: state.facts, status, bytes, recording: recorder.count ? recorder.csv() : '', view: viewNow() };
}

/// The program itself, where it is a worker, so that the saved page can do all that this one can.
async function whole(worker: string): Promise<Packed> {
  const files: Packed['files'] = [],
    part = async (name: string) => base64(await (await fetch(name)).arrayBuffer());
  for (const [i, { name }] of state.facts.entries())
    for (const [what, ending] of [
      ['sqmap', 'sqmap'],
      ['names', 'names.json'],
    ])
      files.push([`${name}.${ending}`, base64(await fetchBytes(`/api/object/${i}/${what}`))]);
  const [script, wasm] = await Promise.all(['program.mjs', 'program.wasm'].map(part));
  return {
    program: { worker: await part(worker), script, wasm },
    files,
    recording: recorder.count ? recorder.csv() : '',
    view: viewNow(),
  };
}

async function page(): Promise<string> {
  const { worker } = document.documentElement.dataset,
    content = worker ? `sqmapPacked=${JSON.stringify(await whole(worker))}` : `sqmapSaved=${JSON.stringify(await said())}`;
  const [script, style] = await Promise.all(['app.js', 'app.css'].map(async (name) => (await fetch(name)).text()));
  return (
    `<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>sqmap: ${state.facts.map((f) => f.name.replace(/[^\w -]/g, '')).join(', ')}</title><style>${style.replaceAll('</style', '')}</style></head>` +
    `<body><div id="app"></div><script>window.${inScript(content)}</script><script type="module">${inScript(script)}</script></body></html>`
  );
}

export const pageButton = h(
  'button',
  {
    id: 'save-page',
    hidden: !!(saved || packed),
    onclick: async () => {
      if (state.facts.some((f) => f.edited)) {
        trouble('Bake the edited parts first.');
        return;
      }
      wait('Writing the page …');
      try {
        save('sqmap.html', await page(), 'text/html');
        wait(
          `Saved${recorder.count ? ', with the recording' : ''}: it opens in any browser${program.kind === 'worker' ? ', and is touched there' : ', without the program'}.`,
        );
      } catch (e) {
        trouble(e);
      }
    },
  },
  'Page in one file',
);

/// Restores the view and the recording of a saved page.
export function restoreSaved(): void {
  if (!saved) return;
  showView(saved.view as Parameters<typeof showView>[0]);
  if (saved.recording) recorder.open(saved.recording);
  recorder.onEnd();
}
/// Restores the view and the recording of a page that has its program inside.
export async function restorePacked(): Promise<void> {
  if (!packed) return;
  showView(packed.view as Parameters<typeof showView>[0]);
  if (packed.recording) await openRecording(new File([packed.recording], 'recording.csv'), () => {}, new AbortController().signal);
}
/// Removes the controls that a saved page cannot serve, once the page is built.
export function leaveOut(): void {
  if (!saved) return;
  for (const id of ['open', 'reading', 'link', 'stop']) document.getElementById(id)!.remove();
  for (const id of ['recognise', 'dress']) tabs[id as Mode].hidden = true;
  for (const o of lookPanel.querySelectorAll<HTMLOptionElement>('#colour option'))
    if (
      o.value !== 'parts' &&
      !(`/api/object/0/field/${o.value}` in saved.bytes || `/api/object/1/field/${o.value}` in saved.bytes)
    )
      o.remove();
  for (const id of ['beside', 'samples', 'offset', 'hidden']) lookPanel.querySelector(`#${id}`)!.closest('label')!.remove();
  lookPanel.querySelector('#slice')!.remove();
  // There is no force without the program: a recording can be replayed, else there is only Look.
  if (!saved.recording) {
    tabs.touch.hidden = true;
    return;
  }
  tabs.touch.textContent = 'Replay';
  for (const id of ['record', 'again', 'save-recording', 'open-recording']) recordingCard.querySelector(`#${id}`)!.remove();
  for (const part of touchPanel.children) (part as HTMLElement).hidden = part !== recordingCard;
  on(['mode', 'status'], () => {
    hand.enabled = false;
    if (state.mode === 'touch' && !recorder.replaying) showHint('This is a recording: press Replay.');
  });
}
