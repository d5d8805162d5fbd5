// States as a shape and words, so that colour is never the only indication.

import { h, s } from "./dom.js";
import { CONDITIONS, CONNECTIONS, FAULTS, SEGMENTERS, say } from "./words.js";

const SHAPES = {
  circle: () => s("circle", { cx: 8, cy: 8, r: 6, class: "fill" }),
  ring: () => [s("circle", { cx: 8, cy: 8, r: 5.5 }), s("path", { d: "M4 12 12 4" })],
  dots: () => [2.5, 8, 13.5].map((cx) => s("circle", { cx, cy: 8, r: 1.6, class: "fill" })),
  diamond: () => s("path", { d: "M8 1 15 8 8 15 1 8Z", class: "fill" }),
  stump: () => [
    s("path", { d: "M2 14h12L11.5 8h-7Z", class: "fill" }),
    s("path", { d: "M6 5 8 1 10 5", "stroke-dasharray": "1.5 1.5" }),
  ],
  // A cut whisker on a pedestal: its place is taken.
  propped: () => [
    s("path", { d: "M4 9h8L10.5 5h-5Z", class: "fill" }),
    s("path", { d: "M2 14h12M4 14v-2.5M12 14v-2.5" }),
  ],
  slope: () => s("path", { d: "M2 3v11h12Z", class: "fill" }),
  down: () => s("path", { d: "M8 2v10M3.5 8 8 13l4.5-5" }),
  clock: () => [s("circle", { cx: 8, cy: 8, r: 6.2 }), s("path", { d: "M8 4v4l3 2" })],
  cross: () => s("path", { d: "M3 3 13 13M13 3 3 13" }),
  drop: () => s("path", { d: "M8 1C11 6 13 8 13 10.5a5 5 0 0 1-10 0C3 8 5 6 8 1Z", class: "fill" }),
  gap: () => s("path", { d: "M1 8h5M10 8h5M6 4.5v7M10 4.5v7" }),
  bell: () => [s("path", { d: "M3 12h10l-1.5-2V7a3.5 3.5 0 0 0-7 0v3Z", class: "fill" }), s("path", { d: "M7 14h2" })],
  tick: () => s("path", { d: "M2.5 8.5 6.5 12.5 13.5 4" }),
  dial: () => [s("path", { d: "M2.5 13a6.5 6.5 0 1 1 11 0" }), s("path", { d: "M8 9 11 5.5" })],
  heat: () => [
    s("path", { d: "M6.5 9V3.2a1.5 1.5 0 0 1 3 0V9" }),
    s("circle", { cx: 8, cy: 11.5, r: 3, class: "fill" }),
  ],
  hand: () => s("path", { d: "M4 3h3v10H4ZM9 3h3v10H9Z", class: "fill" }),
};

/** A shape without words. */
export function shapeOf(shape) {
  return s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true", class: "shape" }, SHAPES[shape]?.() ?? SHAPES.ring());
}

/** A shape and words in a tone; no shape if it is null. */
export function mark(words, tone, shape) {
  return h("span", { class: `mark ${tone}` }, shape === null ? null : shapeOf(shape), h("span", {}, words));
}

/** The mark for a word of the API. */
export function markOf(words, word) {
  const [, tone, shape] = words[word] ?? [null, "off", "ring"];
  return mark(say(words, word), tone, shape);
}

/** The marks of a whisker, the worst first. */
export function marksOf(whisker) {
  const marks = [];
  if (whisker.connection !== "ONLINE") marks.push(markOf(CONNECTIONS, whisker.connection));
  if (whisker.fault) marks.push(markOf(FAULTS, whisker.fault));
  if (whisker.condition !== "TRIMMED") marks.push(markOf(CONDITIONS, whisker.condition));
  else if (isUncompensated(whisker)) marks.push(mark("trimmed, not compensated", "bad", "stump"));
  else marks.push(mark("trimmed, compensated", "info", "propped"));
  if (isInDoubt(whisker)) marks.push(markOf(SEGMENTERS, whisker.segmenter));
  if (whisker.held) marks.push(mark("held by an operator", "info", "hand"));
  return h("span", { class: "marks" }, marks);
}

/** Whether its robot is heard and says that it finds no contacts in its samples of strain, or not all. */
function isInDoubt({ connection, segmenter }) {
  return Boolean(segmenter) && connection === "ONLINE" && SEGMENTERS[segmenter]?.[1] !== "good";
}

/** Whether a whisker is trimmed and has no compensator. */
export function isUncompensated(whisker) {
  return whisker.condition === "TRIMMED" && whisker.compensated_by === null;
}

/** Urgency of a whisker, for the order of lists. */
export function attention(whisker) {
  return (
    (isUncompensated(whisker) ? 32 : 0) +
    (whisker.fault ? 16 : 0) +
    ({ TRIMMED: 8, SENSITIVITY_LOSS: 6, ERODING: 5, SUSPECTED: 4 }[whisker.condition] ?? 0) +
    (whisker.held ? 1 : 0)
  );
}
