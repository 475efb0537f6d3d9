// What several pages have: a heading that takes the focus, a button that goes on, the table of controls.

import { el, fill } from "/web/dom.js";

export const heading = (text) => el("h1", { tabindex: -1 }, text);
export const paragraphs = (texts, words = {}) => texts.map((text) => el("p", {}, fill(text, words)));

/** The button that leads on; the gamepad's A presses it where the page names it as its `primary`. */
export const button = (text, onclick, attributes = {}) => el("button", { type: "button", onclick, ...attributes }, text);

/** Which directions a task leaves free, as a sentence. */
export function freeAxes(texts, { axes, frame }) {
  const ways = texts.axes[frame];
  if (!ways || !axes?.length) return null;
  const named = [...new Set(["x", "y", "z"].filter((axis) => axes.includes(axis)).map((axis) => ways[axis]))];
  const last = named.pop();
  const list = named.length ? named.join(", ") + texts.axes.last + last : last;
  return fill(texts.axes.moves, { axes: list });
}

/** The words of a scene's task; a scene that the texts do not name has the default. */
export const task = (texts, scene) => (Object.hasOwn(texts.tasks, scene) ? texts.tasks[scene] : texts.tasks.default);

/** The controls as a table, in the words of the frame in which the sticks move the tip. */
export function controlTable({ controls }, frame) {
  const words = frame === "camera" ? "camera" : "robot";
  const rows = Object.values(controls.rows).map((row) =>
    el("tr", {}, el("th", { scope: "row" }, row.gamepad), el("td", {}, row[words]), el("td", {}, el("kbd", {}, row.keyboard))),
  );
  const head = [controls.gamepad, controls.does, controls.keyboard].map((text) => el("th", { scope: "col" }, text));
  return [
    el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, rows)),
    el("p", { class: "note" }, controls[words], " ", controls.speed),
  ];
}
