// Force for other senses: sound, rumble, speech.
import { MODES, PLAIN } from './materials';
import type { Frame } from './messages';

const PING = 220,
  FURTHER = 0.002,
  LOWEST = 260; // ms and m from a tone of the position to the next; Hz at an object's foot

/// Turns force into sound: pitch and loudness follow its size, a rustle follows the speed of sliding, a tap marks every new contact.
export class Sound {
  private context: AudioContext | null = null;
  private tone!: OscillatorNode;
  private toneGain!: GainNode;
  private noiseGain!: GainNode;
  private pan!: StereoPannerNode;
  private touching = false;
  private before: number[] | null = null;
  private depthBefore = 0;
  private band!: BiquadFilterNode;
  material = PLAIN; ///< the touched surface's
  size = 0.1; ///< the touched object's, m
  on = false;
  onSwitch: () => void = () => {};

  /// Browsers start sound only from a key or a click.
  start(): void {
    this.on = true;
    this.onSwitch();
    if (this.context) {
      void this.context.resume();
      return;
    }
    const c = new AudioContext();
    this.context = c;
    this.pan = c.createStereoPanner();
    this.pan.connect(c.destination);
    this.tone = c.createOscillator();
    this.tone.type = 'triangle';
    this.toneGain = c.createGain();
    this.toneGain.gain.value = 0;
    this.tone.connect(this.toneGain).connect(this.pan);
    this.tone.start();
    const buffer = c.createBuffer(1, c.sampleRate, c.sampleRate),
      samples = buffer.getChannelData(0);
    for (let i = 0; i < samples.length; ++i) samples[i] = 2 * Math.random() - 1;
    const noise = c.createBufferSource();
    noise.buffer = buffer;
    noise.loop = true;
    const band = c.createBiquadFilter();
    band.type = 'bandpass';
    this.band = band;
    this.noiseGain = c.createGain();
    this.noiseGain.gain.value = 0;
    noise.connect(band).connect(this.noiseGain).connect(this.pan);
    noise.start();
  }

  stop(): void {
    this.on = false;
    this.onSwitch();
    this.quiet();
  }

  quiet(): void {
    if (!this.context) return;
    const t = this.context.currentTime;
    this.toneGain.gain.setTargetAtTime(0, t, 0.02);
    this.noiseGain.gain.setTargetAtTime(0, t, 0.02);
    this.touching = false;
    this.before = null;
  }

  /// Plays a frame. side: the tool's position on the object, -1 left to 1 right.
  play(frame: Frame, side: number): void {
    if (!this.on || !this.context) return;
    const t = this.context.currentTime,
      force = Math.hypot(...frame.force);
    const touching = frame.contacts > 0;
    this.pan.pan.setTargetAtTime(Math.max(-1, Math.min(1, side)), t, 0.03);
    this.tone.frequency.setTargetAtTime(170 * Math.pow(2, Math.min(force, 2.5) * 1.1), t, 0.015);
    this.toneGain.gain.setTargetAtTime(touching ? 0.03 + 0.09 * Math.min(force, 2) : 0, t, 0.02);
    let speed = 0;
    if (this.before) speed = Math.hypot(...frame.tool.map((x, i) => x - this.before![i])) * 60;
    this.before = frame.tool;
    this.noiseGain.gain.setTargetAtTime(touching ? this.material.rustle * Math.min(speed * 3, 0.4) : 0, t, 0.02);
    this.band.frequency.setTargetAtTime(this.material.pitch * (1 + Math.min(speed, 0.5)), t, 0.03);
    if (touching && !this.touching) this.strike(Math.max(frame.depth - this.depthBefore, 0) * 60);
    this.touching = touching;
    this.depthBefore = touching ? frame.depth : 0;
  }

  /// Plays the modes of a bar of the touched object's size and material that is struck at this speed, m/s. The lowest lasts longest.
  strike(speed: number): void {
    if (!this.on || !this.context) return;
    const c = this.context,
      m = this.material,
      lowest = Math.min(Math.max(m.speed / this.size, 60), 2400),
      loud = 0.3 * m.loud * Math.min(0.25 + 2 * speed, 1);
    MODES.forEach((ratio, k) => {
      if (lowest * ratio > 9000) return;
      this.ring(c, lowest * ratio, loud / (1 + 1.2 * k), 3 * Math.max(m.periods / lowest / (1 + 0.6 * k), 0.012));
    });
  }

  /// Guides a hand that looks for an object: a shorter distance gives a higher tone.
  guide(distance: number): void {
    this.tap(900 / (1 + 3 * distance));
  }

  private pinged = { at: 0, tool: [Infinity, 0, 0] };
  /// A short tone while the tool moves: the higher it is on the object, 0 to 1, the higher the tone, over two octaves.
  place(tool: number[], height: number): void {
    const now = performance.now();
    if (!this.on || now - this.pinged.at < PING || Math.hypot(...tool.map((x, k) => x - this.pinged.tool[k])) < FURTHER) return;
    this.pinged = { at: now, tool };
    if (this.context) this.ring(this.context, LOWEST * 4 ** height, 0.07, 0.08);
  }

  tap(pitch: number): void {
    if (this.on && this.context) this.ring(this.context, pitch, 0.18, 0.09);
  }

  /// A tone of that pitch, Hz, that dies away in so many seconds.
  private ring(c: AudioContext, pitch: number, loud: number, lasts: number): void {
    const o = c.createOscillator(),
      g = c.createGain();
    o.frequency.value = pitch;
    g.gain.setValueAtTime(loud, c.currentTime);
    g.gain.exponentialRampToValueAtTime(0.0005, c.currentTime + lasts);
    o.connect(g).connect(this.pan);
    o.start();
    o.stop(c.currentTime + lasts);
  }
}

/// Plays the force's size on every game pad that can rumble.
export class Rumble {
  private last = 0;
  on = true;
  available(): boolean {
    return Array.from(navigator.getGamepads?.() ?? []).some((p) => p && p.vibrationActuator);
  }
  play(force: number, limit: number): void {
    const now = performance.now();
    if (!this.on || force < 0.05 || now - this.last < 80) return;
    this.last = now;
    for (const pad of navigator.getGamepads?.() ?? [])
      void pad?.vibrationActuator
        ?.playEffect('dual-rumble', {
          duration: 110,
          strongMagnitude: Math.min(force / limit, 1),
          weakMagnitude: Math.min((0.6 * force) / limit, 1),
        })
        .catch(() => {});
  }
}

/// Says the name of a part that has been touched for a moment and where the tool is; what is newer replaces what waits.
export class Voice {
  private pending = 0;
  private said = '';
  private saidWhere = '';
  private pends = false; ///< the name of the part has not been said yet
  private heardBy = 0;
  on = false;
  onSay: (text: string) => void = () => {};

  /// A part is touched; knew: it was touched before; where: the tool's position. Says all for another part, else the position alone
  /// once it is another one.
  touch(name: string, knew = false, where = ''): void {
    if (name === this.said && where === this.saidWhere) return;
    const other = name !== this.said || this.pends;
    clearTimeout(this.pending);
    this.said = name;
    this.saidWhere = where;
    this.pends = other && !!name;
    if (!name) return;
    const text = other ? `${name}${knew ? ', touched before' : ''}${where ? `. ${where}` : ''}` : where;
    this.pending = window.setTimeout(
      () => {
        this.pends = false;
        this.say(text);
      },
      Math.max(250, this.heardBy - performance.now()),
    );
  }

  /// Answers a question; a part that is touched meanwhile does not cut the answer short.
  answer(text: string): void {
    clearTimeout(this.pending);
    this.heardBy = performance.now() + 2000;
    this.say(text);
  }
  private say(text: string): void {
    this.onSay(text);
    if (!this.on || !('speechSynthesis' in window)) return;
    speechSynthesis.cancel();
    const words = new SpeechSynthesisUtterance(text);
    words.rate = 1.15;
    speechSynthesis.speak(words);
  }
  forget(): void {
    clearTimeout(this.pending);
    this.said = this.saidWhere = '';
    this.pends = false;
  }
}
