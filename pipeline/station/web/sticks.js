// Sticks as numbers and as a drawing: travel, dead zone, and how far each was pushed.

import { svg } from "/web/dom.js";

const FAR = 0.9; // a stick that reaches this share of its travel was pushed all the way
const RESTING = 0.3; // nobody pushes a stick that stands nearer to its centre than this
export const REST_MS = 2000;
const ENDS = { up: [0, -1], down: [0, 1], left: [-1, 0], right: [1, 0] };

/** A stick's share of full speed, 0 to 1: nothing within the dead zone, and rising from 0 at its edge. */
export function speed(stick, zone) {
  const pushed = Math.min(1, Math.hypot(...stick));
  return pushed <= zone ? 0 : (pushed - zone) / (1 - zone);
}

/** The ends that a stick stands at: of "up", "down", "left" and "right". */
export function ends([x, y]) {
  return Object.keys(ENDS).filter((name) => ENDS[name][0] * x + ENDS[name][1] * y >= FAR);
}

/** Measures where the sticks stand while nobody touches them. */
export class Rest {
  constructor() {
    this.since = null;
    this.largest = 0;
    this.drift = null; // share of the travel, once both rested long enough
  }

  /** Takes a reading. Both sticks have to rest for two seconds in one go; the last such measurement counts. */
  take(left, right, now) {
    const pushed = Math.max(Math.hypot(...left), Math.hypot(...right));
    if (pushed > RESTING) {
      this.since = null;
      this.largest = 0;
      return;
    }
    this.since ??= now;
    this.largest = Math.max(this.largest, pushed);
    if (now - this.since < REST_MS) return;
    this.drift = this.largest;
    this.since = now;
    this.largest = 0;
  }
}

/** A stick drawn: its travel, the dead zone, the ends that were reached, and where it stands. */
export class StickDrawing {
  constructor(wanted, zone) {
    this.dot = svg("circle", { class: "dot", r: 0.1 });
    this.reached = new Set();
    this.marks = Object.fromEntries(
      wanted.map((name) => {
        const [x, y] = ENDS[name];
        return [name, svg("circle", { class: "end", cx: x, cy: y, r: 0.055 })];
      }),
    );
    this.element = svg(
      "svg",
      { class: "stick", viewBox: "-1.2 -1.2 2.4 2.4", "aria-hidden": "true" },
      svg("circle", { class: "travel", r: 1 }),
      svg("path", { class: "cross", d: "M-1 0H1M0-1V1" }),
      svg("circle", { class: "zone", r: zone }),
      Object.values(this.marks),
      this.dot,
    );
  }

  show([x, y]) {
    const length = Math.max(1, Math.hypot(x, y)); // many sticks travel in a square, past the circle
    this.dot.setAttribute("cx", x / length);
    this.dot.setAttribute("cy", y / length);
    for (const name of ends([x, y])) {
      this.reached.add(name);
      this.marks[name]?.classList.add("reached");
    }
  }

  /** Whether every end that was asked for has been reached. */
  get done() {
    return Object.keys(this.marks).every((name) => this.reached.has(name));
  }
}
