// NASA-TLX: six lines of 21 marks, 0 to 100 in steps of 5. A line has no mark until the participant sets one.

import { el, fill, say } from "/web/dom.js";
import { button, heading, task } from "/web/parts.js";

const STEP = 5;
const SETS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown", " ", "Enter"]);

/** A line of marks: a range input that counts as answered once it was touched. */
function scale(words, name, onset) {
  const own = words.scales[name];
  const open = el("span", {}, words.unanswered);
  const line = el("input", {
    type: "range", id: `tlx-${name}`, min: 0, max: 100, step: STEP, value: 50, class: "unset",
    "aria-describedby": `tlx-${name}-question`, "aria-valuetext": words.unanswered,
  });
  const set = () => {
    line.classList.remove("unset");
    line.setAttribute("aria-valuetext", fill(words.value, { value: line.value }));
    say(open, ""); // the mark says it; a number would tempt to compare
    onset();
  };
  for (const event of ["input", "pointerdown"]) line.addEventListener(event, set);
  line.addEventListener("keydown", ({ key }) => SETS.has(key) && set());
  const element = el(
    "div", { class: "scale" },
    el("label", { for: `tlx-${name}` }, own.name),
    el("p", { class: "question", id: `tlx-${name}-question` }, own.question, el("span", { class: "unseen" }, ` ${own.low} – ${own.high}`)),
    line,
    el("p", { class: "ends", "aria-hidden": "true" }, el("span", {}, own.low), open, el("span", {}, own.high)),
  );
  return { name, element, line, answered: () => !line.classList.contains("unset") };
}

export function tlx({ texts, answer }, data) {
  const words = texts.tlx;
  const missing = el("p", { class: "note", role: "status" });
  const open = () => scales.filter((each) => !each.answered());
  const tell = () => {
    if (open().length === 0) say(missing, "");
  };
  const scales = Object.keys(words.scales).map((name) => scale(words, name, tell));
  const next = button(words.next, () => {
    const [first] = open();
    if (first) {
      say(missing, fill(words.missing, { scales: open().map(({ name }) => words.scales[name].name).join(", ") }));
      first.line.focus();
      return;
    }
    answer("tlx", Object.fromEntries(scales.map(({ name, line }) => [name, Number(line.value)])));
  });
  return {
    parts: [
      heading(words.heading),
      el("p", { class: "lede" }, fill(words.lede, { name: task(texts, data.scene).name })),
      scales.map(({ element }) => element),
      missing,
      el("p", { class: "actions" }, next),
    ],
  };
}
