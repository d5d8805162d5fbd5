// An array drawn to scale from the API's data of its whiskers: present length as a solid shape, whole length as an
// outline, and an arrow from each compensator to its target.

import { s } from "./dom.js";
import { mm, mpa } from "./format.js";
import { isUncompensated } from "./marks.js";
import { link } from "./places.js";
import { CONDITIONS, CONNECTIONS, FAULTS, say } from "./words.js";

/** All in mm, like the array. The widths of base and tip are those of the paper's cone. */
const BASE_MM = 10;
const TIP_MM = 3;
const SIDE_MM = 16;
const HEAD_MM = 14;
const FOOT_MM = 33;
/** The same scale for all arrays, for comparison; on narrow screens a smaller one, at which texts are still legible. */
const PIXELS_PER_MM = 3.2;
const PIXELS_PER_MM_NARROW = 2.5;

/**
 * One picture per row of whiskers with equal `y_mm`; a row that is wider than `width` px continues in further pictures.
 * `serving` are active compensations.
 */
export function drawing(whiskers, serving, width) {
  const rows = Map.groupBy(whiskers, (whisker) => whisker.y_mm);
  const ordered = [...rows].sort(([one], [other]) => one - other);
  const sorted = ordered.map(([y, row]) => [y, [...row].sort((one, other) => one.x_mm - other.x_mm)]);
  const fits = (scale) => sorted.every(([, row]) => (row.at(-1).x_mm - row[0].x_mm + 2 * SIDE_MM) * scale <= width);
  const scale = fits(PIXELS_PER_MM) ? PIXELS_PER_MM : PIXELS_PER_MM_NARROW;
  const where = (y) => (ordered.length > 1 ? `, row at ${mm(y, 0)}` : "");
  return sorted.flatMap(([y, row]) => parts(row, width / scale).map((part) => picture(part, where(y), serving, scale)));
}

/** Parts of a row of whiskers, sorted by `x_mm`, that are at most so wide. */
function parts(row, widthMm) {
  const all = [[]];
  for (const whisker of row) {
    const first = all.at(-1)[0];
    if (first && whisker.x_mm - first.x_mm + 2 * SIDE_MM > widthMm) all.push([]);
    all.at(-1).push(whisker);
  }
  return all;
}

function picture(row, where, serving, scale) {
  const left = Math.min(...row.map((one) => one.x_mm)) - SIDE_MM;
  const right = Math.max(...row.map((one) => one.x_mm)) + SIDE_MM;
  const top = Math.max(...row.map((one) => Math.max(one.whole_length_mm, one.length_mm)));
  const box = [left, -top - HEAD_MM, right - left, top + HEAD_MM + FOOT_MM].map((side) => side.toFixed(1));
  const name = `Array ${row[0].array} to scale${where}`;
  const arrows = serving.map((decision) => arrow(decision, row)).filter(Boolean);
  return s(
    "svg",
    {
      viewBox: box.join(" "),
      class: "drawing",
      role: "group",
      "aria-label": name,
      width: box[2] * scale,
      height: box[3] * scale,
    },
    s("title", {}, name),
    s("line", { x1: left, x2: right, y1: 0, y2: 0, class: "ground" }),
    row.map((whisker) => one(whisker)),
    arrows,
  );
}

function cone(x, length, bottom = BASE_MM, tip = TIP_MM) {
  const at = (dx, y) => `${(x + dx).toFixed(2)} ${y.toFixed(2)}`;
  return `M${at(-bottom / 2, 0)}L${at(-tip / 2, -length)}L${at(tip / 2, -length)}L${at(bottom / 2, 0)}Z`;
}

/** Width of a whole whisker at the present length, where a cut one ends. */
function widthAt(whisker) {
  return (
    BASE_MM - ((BASE_MM - TIP_MM) * Math.min(whisker.length_mm, whisker.whole_length_mm)) / whisker.whole_length_mm
  );
}

function one(whisker) {
  const { x_mm: x, length_mm: length, whole_length_mm: whole } = whisker;
  const [word, tone, told = word] = worst(whisker);
  const words = `Whisker ${whisker.whisker}: ${told}, ${mm(length, 1)} of ${mm(whole, 1)}, ${mpa(whisker.pressure_mpa ?? whisker.setpoint_mpa, 3)}`;
  // The link says in words what the picture beside it shows.
  return s(
    "g",
    { "data-key": `whisker-${whisker.whisker}`, class: `whisker ${tone}` },
    s(
      "a",
      { href: link.whisker(whisker), "aria-label": words },
      s("title", {}, words),
      s("rect", {
        x: x - SIDE_MM / 2 - 2,
        y: -whole - 8,
        width: SIDE_MM + 4,
        height: whole + 32,
        class: "target",
        rx: 2,
      }),
    ),
    s(
      "g",
      { class: "seen", "aria-hidden": "true" },
      s("path", { d: cone(x, whole), class: "whole" }),
      s("path", { d: cone(x, length, BASE_MM, widthAt(whisker)), class: "body" }),
      whisker.condition === "TRIMMED" ? compensation(whisker) : null,
      interval(whisker),
      s("text", { x, y: -Math.max(whole, length) - 4, class: "length" }, length.toFixed(1)),
      s("text", { x, y: 9, class: "name" }, whisker.whisker),
      s("text", { x, y: 16, class: "state" }, word),
      s("text", { x, y: 22, class: "state" }, `${(whisker.pressure_mpa ?? whisker.setpoint_mpa).toFixed(3)}`),
    ),
  );
}

/** A cross on a trimmed whisker without a compensation, a tick on one with: they differ without their colour, too. */
function compensation(whisker) {
  const { x_mm: x, length_mm: length } = whisker;
  const y = -length / 2;
  const cross = `M${x - 3} ${y - 3}l6 6m0 -6l-6 6`;
  const tick = `M${x - 3} ${y}l2 2.5l4 -5`;
  return isUncompensated(whisker)
    ? s("path", { d: cross, class: "sign refused" })
    : s("path", { d: tick, class: "sign served" });
}

function interval({ x_mm: x, length_low_mm: low, length_high_mm: high }) {
  return s("path", { d: `M${x} ${-low}V${-high}M${x - 1.5} ${-low}h3M${x - 1.5} ${-high}h3`, class: "interval" });
}

/** The most important word about a whisker, because the drawing has little space. */
function worst(whisker) {
  if (whisker.connection !== "ONLINE") {
    const words = say(CONNECTIONS, whisker.connection);
    return [words.split(" ").at(-1), "off", words];
  }
  if (whisker.fault)
    return [say(FAULTS, whisker.fault).split(":")[0].split(" ")[0], FAULTS[whisker.fault]?.[1] ?? "bad"];
  if (whisker.condition === "TRIMMED") {
    return isUncompensated(whisker)
      ? ["trimmed", "bad", "trimmed, not compensated"]
      : ["trimmed", "info", "trimmed, compensated"];
  }
  return [say(CONDITIONS, whisker.condition).split(" ").at(-1), CONDITIONS[whisker.condition]?.[1] ?? "off"];
}

/** An arrow from the compensator's foot to the target's; a loop for self-compensation; a note if only one is in the row. */
function arrow(decision, row) {
  const [from, to] = [decision.compensator_whisker, decision.target_whisker].map((number) =>
    row.find((one) => one.whisker === number),
  );
  if (!from && !to) return null;
  if (!from) return s("text", { x: to.x_mm, y: 28, class: "note" }, `by ${decision.compensator_whisker}`);
  if (!to) return s("text", { x: from.x_mm, y: 28, class: "note" }, `for ${decision.target_whisker}`);
  const words =
    from === to
      ? `Whisker ${to.whisker} compensates for itself`
      : `Whisker ${from.whisker} compensates for whisker ${to.whisker}`;
  const [start, end] = from === to ? [from.x_mm - 4, to.x_mm + 4] : [from.x_mm, to.x_mm];
  const [y, low] = [25, 31];
  const way = Math.sign(end - start);
  const line = `M${start} ${y}C${start} ${low} ${end} ${low} ${end} ${y}`;
  const head = `M${end - 1.6 - way * 0.4} ${y + 2.2}L${end} ${y}L${end + 1.6 - way * 0.4} ${y + 2.4}`;
  return s(
    "g",
    { class: "arrow", role: "img", "aria-label": words },
    s("title", {}, words),
    s("path", { d: line }),
    s("path", { d: head }),
  );
}
