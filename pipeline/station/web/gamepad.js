// The gamepad test: which sticks and buttons there are, whether all of them work, and how far the sticks drift.

import { el, fill, say } from "/web/dom.js";
import { BUTTONS, gamepads, readGamepad } from "/web/inputs.js";
import { button, heading } from "/web/parts.js";
import { Rest, StickDrawing, speed } from "/web/sticks.js";

/** What the arm heeds of the right stick. */
const upright = ([, y]) => [0, y];

/** A stick with its name and what it does now. */
function stickPart(words, name, wanted, zone, used = (stick) => stick) {
  const drawing = new StickDrawing(wanted, zone);
  const now = el("span", { class: "reading" });
  const element = el("figure", {}, drawing.element, el("figcaption", {}, el("strong", {}, name), now));
  const show = (stick) => {
    drawing.show(stick);
    const share = speed(used(stick), zone);
    say(now, share > 0 ? fill(words.outside, { percent: Math.round(100 * share) }) : words.inside);
  };
  return { element, show, drawing };
}

/** The three buttons that are used as lamps, and how many of all are pressed. */
function lampsPart(words) {
  const lamps = Object.fromEntries(Object.keys(BUTTONS).map((name) => [name, el("li", { class: "lamp" }, words[name])]));
  const count = el("p", { class: "reading" });
  const element = el("div", { class: "lamps" }, el("h2", {}, words.buttons), el("ul", {}, Object.values(lamps)), count);
  const show = (pressed, pad) => {
    for (const [name, lamp] of Object.entries(lamps)) lamp.classList.toggle("on", pressed.includes(name));
    say(count, fill(words.pressed, { count: pad ? pad.buttons.filter((each) => each.pressed).length : 0 }));
  };
  return { element, show };
}

/** The list of what is to be tried; says what has been done. */
function stepsPart(words) {
  const rows = Object.fromEntries(
    Object.entries(words.steps).map(([name, text]) => {
      const state = el("span", { class: "state" }, words.step_open);
      return [name, { text, state, element: el("li", {}, el("span", {}, text), state) }];
    }),
  );
  const done = new Set();
  const finish = (name, news) => {
    if (done.has(name)) return;
    done.add(name);
    rows[name].element.classList.add("done");
    say(rows[name].state, words.step_done);
    say(news, `${rows[name].text}: ${words.step_done}`);
  };
  const element = el("ul", { class: "steps" }, Object.values(rows).map((row) => row.element));
  return { element, finish, all: () => done.size === Object.keys(rows).length };
}

export function gamepad(station, data) {
  const { texts, news } = station;
  const words = texts.gamepad;
  const zone = data.dead_zone ?? 0;
  const left = stickPart(words, words.left, ["up", "down", "left", "right"], zone);
  const right = stickPart(words, words.right, ["up", "down"], zone, upright);
  const [lamps, steps, rest] = [lampsPart(words), stepsPart(words), new Rest()];
  const [told, drift] = [el("p", { class: "told", role: "status" }, words.waiting), el("p", { class: "drift", role: "status" })];
  let [seen, device] = [false, ""];

  const go = (source) => station.answer("gamepad", {
    source, device: source === "gamepad" ? device : "keyboard", mapping: source === "gamepad" ? "standard" : "",
    drift: source === "gamepad" ? rest.drift : 0, window: [innerWidth, innerHeight], pixel_ratio: devicePixelRatio,
  });
  const next = button(words.next, () => go("gamepad"), { disabled: true });
  const onKeyboard = button(words.keyboard, () => go("keyboard"), { class: "quiet" });

  function tell({ standard, unsupported }) {
    if (standard) say(told, fill(words.connected, { device }));
    else if (unsupported) say(told, fill(words.unsupported, { device: unsupported.id }));
    else say(told, seen ? words.disconnected : words.waiting);
    told.classList.toggle("bad", !standard && (seen || unsupported !== null));
  }

  function measure(now, { left: l, right: r, pressed }) {
    rest.take(l, upright(r), now);
    if (rest.drift !== null) {
      const bad = rest.drift > zone;
      const shares = { drift: station.number(100 * rest.drift, 1), zone: station.number(100 * zone, 0) };
      say(drift, fill(bad ? words.drift_bad : words.drift, shares));
      drift.classList.toggle("bad", bad);
      steps.finish("rest", news);
    }
    if (left.drawing.done) steps.finish("left", news);
    if (right.drawing.done) steps.finish("right", news);
    for (const name of ["a", "start"]) if (pressed.includes(name)) steps.finish(name, news);
  }

  function update(state, now) {
    const found = gamepads();
    if (found.standard) [seen, device] = [true, found.standard.id.slice(0, 120)];
    tell(found);
    const reading = found.standard ? readGamepad(found.standard) : { left: [0, 0], right: [0, 0], pressed: [] };
    left.show(reading.left);
    right.show(reading.right);
    lamps.show(reading.pressed, found.standard);
    if (found.standard) measure(now, reading);
    next.disabled = !(found.standard && steps.all());
  }

  return {
    update,
    parts: [
      heading(words.heading),
      el("p", { class: "lede" }, words.lede),
      told,
      el("div", { class: "pad" }, left.element, right.element, lamps.element, steps.element),
      drift,
      el("p", { class: "actions" }, next, onKeyboard),
    ],
  };
}
