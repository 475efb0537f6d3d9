// Practice and trial: the live picture, as large as the window allows, and nothing else of the scene.

import { clock, el, fill, say } from "/web/dom.js";
import { button, freeAxes, heading, task } from "/web/parts.js";

export function trial(station, data) {
  const words = station.texts.trial;
  return drive(station, data, fill(words.heading, data), []);
}

export function practice(station, data) {
  const words = station.texts.practice;
  const begun = performance.now();
  const clockface = el("span", { class: "clock" });
  const next = button(words.next, () => station.answer("practice"), { disabled: true });
  const page = drive(station, data, words.heading, [clockface, next]);
  const update = (state, now) => {
    page.update();
    const elapsed = (data.elapsed_s ?? 0) + (now - begun) / 1000;
    const left = (data.least_s ?? 0) - elapsed;
    if (left <= 0 && next.disabled) next.disabled = false;
    const most = { time: clock((data.most_s ?? elapsed) - elapsed) };
    say(clockface, left > 0 ? fill(words.left_over, { time: clock(left) }) : fill(words.most_left, most));
  };
  return { ...page, update };
}

/** A page with the picture; buttons and sticks go to the arm. */
function drive({ texts, screen, press }, data, title, extra) {
  const words = texts.trial;
  const waiting = el("p", { class: "waiting" }, words.waiting);
  screen.canvas.setAttribute("aria-label", words.picture);
  const sentence = data.scene ? task(texts, data.scene).sentence : texts.practice.short;
  return {
    driving: true,
    update: () => {
      waiting.hidden = !screen.empty;
      screen.canvas.classList.toggle("empty", screen.empty);
    },
    parts: [
      el("div", { class: "above" }, heading(title), extra, button(words.pause, () => press("pause"), { class: "quiet" })),
      el("div", { class: "view" }, screen.canvas, waiting),
      el("p", { class: "below" }, el("span", {}, sentence), " ", el("span", {}, freeAxes(texts, data))),
    ],
  };
}
