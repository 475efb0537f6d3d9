// The experimenter's bar: how the station runs. Nothing of it is announced or moves.

import { el, fill, say } from "/web/dom.js";

export class Bar {
  constructor(element, texts, number) {
    [this.words, this.number] = [texts.bar, number];
    this.cells = Object.fromEntries(["renderer", "rate", "latency", "factor", "flags"].map((key) => [key, el("span", { class: key })]));
    element.setAttribute("aria-label", this.words.label);
    element.replaceChildren(...Object.values(this.cells));
    this.element = element;
  }

  show(status) {
    const words = this.words;
    const size = status.picture ? ` ${status.picture.join(" × ")}` : "";
    const text = {
      renderer: `${words.renderer} ${status.renderer}${size}`,
      rate: fill(words.rate, { fps: this.number(status.fps, 1) }),
      latency: fill(words.latency, { p50: this.number(status.latency_ms_p50, 0), p95: this.number(status.latency_ms_p95, 0) }),
      factor: fill(words.factor, { factor: this.number(status.real_time_factor, 2) }),
      flags: (status.flags ?? []).map((flag) => words.flags[flag] ?? flag).join(", "),
    };
    for (const [key, cell] of Object.entries(this.cells)) say(cell, text[key]);
  }
}
