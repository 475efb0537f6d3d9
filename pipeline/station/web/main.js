// The participant's page: one WebSocket, pages that the station chooses, and a loop over animation frames.

import { Bar } from "/web/bar.js";
import { Connection, TEXTS, reason } from "/web/connection.js";
import { practice, trial } from "/web/driving.js";
import { gamepad } from "/web/gamepad.js";
import { Inputs } from "/web/inputs.js";
import { Latency } from "/web/latency.js";
import { consent, error, feedback, instructions, paused, ready, rest, thanks } from "/web/pages.js";
import { Screen } from "/web/picture.js";
import { tlx } from "/web/tlx.js";

const PAGES = { consent, instructions, gamepad, practice, ready, trial, feedback, paused, break: rest, tlx, thanks, error };
const INTERACTIVE = "button, input, select, textarea, a[href]";

class Station {
  constructor(texts) {
    this.texts = texts;
    this.root = document.getElementById("page");
    this.news = document.getElementById("news");
    this.bar = new Bar(document.getElementById("bar"), texts, this.number);
    this.screen = new Screen();
    this.inputs = new Inputs();
    this.page = { parts: [] };
    document.documentElement.lang = texts.language;
    this.#listen();
    this.connect();
    requestAnimationFrame(this.#frame);
  }

  /** A number in the texts' language, with so many digits after the point; a dash where there is none. */
  number = (value, digits, least = digits) => {
    const form = { minimumFractionDigits: least, maximumFractionDigits: digits };
    return Number.isFinite(value) ? new Intl.NumberFormat(this.texts.language, form).format(value) : "–";
  };

  connect() {
    this.latency = new Latency();
    this.connection = new Connection({
      message: (message) => this.#message(message),
      picture: (buffer) => this.screen.receive(buffer).catch(() => this.#end("protocol")),
      closed: (reason) => this.page.last || this.show("error", { reason }),
    });
  }

  /** Loads the page again where the station answers: the browser's own page for a dead one helps nobody. */
  retry = async () => {
    const why = await reason(0, false);
    if (why === "taken") location.reload(); // it answers; whether it still is taken, the next page says
    else this.show("error", { reason: why });
  };

  /** Leaves the page by its answer; a second press before the next page is there says nothing more. */
  answer = (page, values = {}) => {
    if (this.page.left) return;
    this.page.left = true;
    this.connection.send({ type: "answer", page, values });
  };

  press = (name) => this.connection.send({ type: "button", name });

  #message(message) {
    if (message.type === "page") this.show(message.name, message.data ?? {});
    else if (message.type === "status") this.bar.show(message);
  }

  #end(reason) {
    this.show("error", { reason });
    this.connection.socket.close();
  }

  /** Shows a page; its heading gets the focus, so that it is read out and the keyboard begins there. */
  show(name, data) {
    const make = Object.hasOwn(PAGES, name) ? PAGES[name] : null;
    if (!make) return this.#end("protocol");
    this.screen.clear();
    this.inputs.release();
    this.page = make(this, data);
    this.root.replaceChildren(...this.page.parts.flat().filter(Boolean));
    document.body.dataset.page = name;
    this.bar.element.hidden = !this.page.driving;
    const heading = this.root.querySelector("h1");
    document.title = `${heading.textContent} · ${this.texts.title}`;
    scrollTo(0, 0);
    heading.focus();
  }

  #frame = (at) => {
    requestAnimationFrame(this.#frame);
    const now = performance.now();
    const state = this.inputs.read();
    if (this.page.driving) this.#drive(state, now);
    else if (state.pressed.includes("a")) this.page.primary?.click();
    this.#drawn();
    this.page.update?.(state, now); // after drawing: it shows the canvas in the frame of its first picture
  };

  #drive(state, now) {
    const message = this.inputs.message(state, now);
    if (message) {
      this.latency.read(message.seq, now);
      this.connection.send(message);
    }
    for (const name of state.pressed) this.press(name);
    if (state.lost) this.press("pause");
  }

  #drawn() {
    const drawn = this.screen.draw();
    if (!drawn) return;
    const latency = this.latency.drawn(drawn.seq, performance.now());
    this.connection.send({ type: "drawn", frame: drawn.frame, latency_ms: latency });
  }

  #listen() {
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
    addEventListener("blur", () => this.inputs.release());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden && this.page.driving) this.press("pause");
    });
  }

  /** Keys belong to the arm, but those that press a focused control, and those that belong to the browser.
   *
   * A key that is still down from the page before repeats; it is not a press, or Enter would end a trial that it began.
   */
  #key(event, down) {
    if (down && (event.ctrlKey || event.altKey || event.metaKey)) return;
    const control = event.target instanceof Element && event.target.matches(INTERACTIVE);
    if (control || !(this.page.driving || event.code.endsWith("Enter"))) {
      this.inputs.key(event.code, false);
      return;
    }
    if (event.repeat || this.inputs.key(event.code, down)) event.preventDefault();
  }
}

const answer = await fetch(TEXTS, { cache: "no-store" });
if (answer.ok) new Station(await answer.json());
