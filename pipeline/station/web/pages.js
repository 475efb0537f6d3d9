// The pages that are read and left by a button. A page is a function (station, data) => {parts, primary?}.
// `station` has texts, answer(page, values), press(button) and retry(); `primary` is the button that the gamepad's A presses.

import { el, fill } from "/web/dom.js";
import { button, controlTable, freeAxes, heading, paragraphs, task } from "/web/parts.js";

/** Consent is given with the mouse or the keyboard, after ticking that it was read: never by a gamepad's button. */
export function consent({ texts, answer }, data) {
  const { consent: words } = texts;
  const values = (accepted) => ({ accepted, version: words.version });
  const accept = button(words.accept, () => answer("consent", values(true)), { disabled: true });
  const agree = el("input", { type: "checkbox", id: "agree", onchange: () => (accept.disabled = !agree.checked) });
  const decline = button(words.decline, () => answer("consent", values(false)), { class: "quiet" });
  return {
    parts: [
      heading(words.heading),
      paragraphs(words.paragraphs),
      el("p", { class: "tick" }, agree, el("label", { for: "agree" }, words.agree)),
      el("p", { class: "actions" }, accept, decline),
    ],
  };
}

export function instructions({ texts, answer, number }, data) {
  const { instructions: words } = texts;
  const known = ["trials", "blocks", "least_s", "most_s"].every((key) => Number.isFinite(data[key]));
  const minutes = (seconds) => number(seconds / 60, 1, 0);
  const extent = known && fill(words.extent, { ...data, least: minutes(data.least_s), most: minutes(data.most_s) });
  const primary = button(words.next, () => answer("instructions"));
  return {
    primary,
    parts: [
      heading(words.heading),
      paragraphs(words.paragraphs),
      extent ? el("p", {}, extent) : null,
      el("h2", {}, words.controls),
      controlTable(texts, data.frame),
      el("p", { class: "actions" }, primary),
    ],
  };
}

export function ready({ texts, answer }, data) {
  const { ready: words } = texts;
  const { name, sentence } = task(texts, data.scene);
  const free = freeAxes(texts, data);
  const primary = button(words.next, () => answer("ready"));
  return {
    primary,
    parts: [
      el("p", { class: "eyebrow" }, fill(words.place, data)),
      heading(words.heading),
      el("h2", {}, name),
      el("p", { class: "lede" }, sentence),
      free ? el("p", {}, free) : null,
      el("p", { class: "actions" }, primary),
      el("p", { class: "note" }, words.begin),
    ],
  };
}

export function feedback({ texts, answer, number }, data) {
  const { feedback: words } = texts;
  const measured = { time: number(data.time_s, 1), distance: number(data.distance_m * 1000, 0) };
  const outcome = data.outcome in words ? words[data.outcome] : words.aborted;
  const primary = button(words.next, () => answer("feedback"));
  return { primary, parts: [heading(words.heading), el("p", { class: "lede" }, fill(outcome, measured)), el("p", { class: "actions" }, primary)] };
}

export function paused({ texts, press }, data) {
  const { paused: words } = texts;
  const primary = button(words.next, () => press("resume"));
  const text = data.practice ? [words.practice] : words.paragraphs;
  return { primary, parts: [heading(words.heading), paragraphs(text), el("p", { class: "actions" }, primary)] };
}

export function rest({ texts, answer }, data) {
  const { break: words } = texts;
  const primary = button(words.next, () => answer("break"));
  return { primary, parts: [heading(words.heading), paragraphs(words.paragraphs, data), el("p", { class: "actions" }, primary)] };
}

export function thanks({ texts }, data) {
  const { thanks: words } = texts;
  const code = data.code ? el("p", { class: "code" }, fill(words.code, data)) : null;
  return { last: true, parts: [heading(words.heading), paragraphs(data.declined ? [words.declined] : words.paragraphs), code] };
}

export function error({ texts, retry }, data) {
  const words = Object.hasOwn(texts.errors, data.reason) ? texts.errors[data.reason] : texts.errors.protocol;
  return {
    last: true,
    parts: [
      heading(words.heading),
      el("p", {}, words.text),
      data.detail ? el("p", { class: "note" }, data.detail) : null,
      el("p", { class: "actions" }, button(words.next, retry)),
    ],
  };
}
