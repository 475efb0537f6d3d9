// What the participant's hands do: the gamepad's standard mapping, or the keyboard.

export const BUTTONS = { a: 0, start: 9, pause: 8 }; // places in the standard mapping
const KEY_BUTTONS = { Enter: "a", NumpadEnter: "a", Space: "start", KeyP: "pause" };
const KEY_STICKS = {
  KeyW: ["left", 1, -1], KeyS: ["left", 1, 1], KeyA: ["left", 0, -1], KeyD: ["left", 0, 1],
  ArrowUp: ["right", 1, -1], ArrowDown: ["right", 1, 1], ArrowLeft: ["right", 0, -1], ArrowRight: ["right", 0, 1],
};
const MEANT = 0.3; // a stick this far from its centre is moved by a hand
const LONGEST_SILENCE_MS = 180; // the server hears of the sticks at least every 200 ms
const SHORTEST_GAP_MS = 12; // and at most some eighty times a second, on fast displays too

/** The gamepads of the browser as {standard, unsupported}: the first usable one and the first other one, or null. */
export function gamepads(found = navigator.getGamepads()) {
  const there = Array.from(found).filter((pad) => pad?.connected);
  return {
    standard: there.find((pad) => pad.mapping === "standard") ?? null,
    unsupported: there.find((pad) => pad.mapping !== "standard") ?? null,
  };
}

const clamp = (value) => Math.min(1, Math.max(-1, Number.isFinite(value) ? value : 0));

/** Sticks and pressed buttons of a gamepad with the standard mapping. */
export function readGamepad(pad) {
  const [lx, ly, rx, ry] = [0, 1, 2, 3].map((axis) => clamp(pad.axes[axis]));
  const pressed = Object.keys(BUTTONS).filter((name) => pad.buttons[BUTTONS[name]]?.pressed);
  return { left: [lx, ly], right: [rx, ry], pressed };
}

/** Sticks and pressed buttons that the held keys stand for; opposite keys cancel. */
export function readKeys(held) {
  const read = { left: [0, 0], right: [0, 0], pressed: [] };
  for (const key of held) {
    const [stick, axis, way] = KEY_STICKS[key] ?? [];
    if (stick) read[stick][axis] += way;
    if (KEY_BUTTONS[key]) read.pressed.push(KEY_BUTTONS[key]);
  }
  return read;
}

const neutral = () => ({ left: [0, 0], right: [0, 0], pressed: [] });
const moves = ({ left, right, pressed }) => pressed.length > 0 || [...left, ...right].some((x) => Math.abs(x) > MEANT);

/** One reading an animation frame of whichever of gamepad and keyboard was used last. */
export class Inputs {
  constructor(pads = gamepads) {
    this.pads = pads;
    this.held = new Set();
    this.source = "keyboard";
    this.started = false;
    this.before = { gamepad: new Set(), keyboard: new Set() };
    this.tapped = new Set(); // keys pressed since the last reading, released ones too
    this.seq = 0;
    this.sent = null;
    this.sentAt = -Infinity;
  }

  /** Says whether the key is one of ours, so that the page does not scroll by it. */
  key(code, down) {
    if (!Object.hasOwn(KEY_STICKS, code) && !Object.hasOwn(KEY_BUTTONS, code)) return false;
    if (down && !this.held.has(code)) this.tapped.add(code);
    if (down) this.held.add(code);
    else this.held.delete(code);
    return true;
  }

  /** Lets go of all keys: a window without the focus does not hear of their release. */
  release() {
    this.held.clear();
    this.tapped.clear();
  }

  /** {left, right, source, device, pressed: buttons that were not down before, lost: the gamepad in use went away}. */
  read() {
    const { standard } = this.pads();
    const keys = readKeys(new Set([...this.tapped, ...this.held]));
    const pad = standard ? readGamepad(standard) : null;
    const used = this.source;
    if (this.tapped.size > 0) this.source = "keyboard";
    else if (pad && (moves(pad) || !this.started)) this.source = "gamepad";
    this.tapped.clear();
    this.started ||= pad !== null;
    const lost = used === "gamepad" && this.hadPad === true && pad === null;
    this.hadPad = pad !== null;
    const state = this.source === "gamepad" ? (pad ?? neutral()) : keys;
    const device = this.source === "gamepad" ? (standard?.id ?? "") : "keyboard";
    const pressed = [...this.#fresh("gamepad", pad ?? neutral()), ...this.#fresh("keyboard", keys)];
    return { left: state.left, right: state.right, source: this.source, device, pressed, lost };
  }

  #fresh(source, { pressed }) {
    const fresh = pressed.filter((name) => !this.before[source].has(name));
    this.before[source] = new Set(pressed);
    return fresh;
  }

  /** The message for a reading, or null where nothing has to be said yet. */
  message({ left, right, source, device }, now) {
    const content = JSON.stringify([left, right, source]);
    const silence = now - this.sentAt;
    if (silence < SHORTEST_GAP_MS) return null;
    if (content === this.sent && silence < LONGEST_SILENCE_MS) return null;
    this.sent = content;
    this.sentAt = now;
    this.seq += 1;
    return { type: "input", seq: this.seq, left, right, source, device: device.slice(0, 120) };
  }
}
