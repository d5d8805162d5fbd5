// The candidates of a decision as a list: chosen or why not, what each would need, and its predicted error on one
// scale.

import { h } from "../dom.js";
import { interval, mm, mpa } from "../format.js";
import { mark } from "../marks.js";
import { link, names } from "../places.js";
import { CASES, REFUSALS, say } from "../words.js";
import { errorPicture } from "./effect.js";
import { error } from "./decisions.js";

const VERDICTS = [(one) => one.chosen, (one) => !one.refused, (one) => one.refused === "COSTS_MORE", () => true];

/** The chosen one first, then those that could serve, then the others; the smaller error first. */
function ordered(candidates) {
  const rank = (one) => VERDICTS.findIndex((is) => is(one));
  return [...candidates].sort(
    (one, other) => rank(one) - rank(other) || (one.predicted_error ?? 9) - (other.predicted_error ?? 9),
  );
}

/** The alternatives of a decision. */
export function alternatives(decision) {
  if (!decision.candidates.length) return h("p", { class: "empty" }, "No whisker of the array could be asked.");
  return h(
    "ol",
    { class: "alternatives" },
    ordered(decision.candidates).map((one) => candidate(decision, one)),
  );
}

function candidate(decision, one) {
  const own = one.whisker === decision.target_whisker;
  const verdict = one.chosen
    ? mark("chosen", "good", "tick")
    : mark(one.refused ? say(REFUSALS, one.refused) : "not needed", "off", "ring");
  const length = interval(
    one.length_mm,
    one.length_mm - 1.96 * one.length_sd_mm,
    one.length_mm + 1.96 * one.length_sd_mm,
    mm,
  );
  const pressure =
    one.pressure_mpa === null
      ? "no pressure fits"
      : `${one.pressure_before_mpa.toFixed(4)} to ${mpa(one.pressure_mpa)}`;
  return h(
    "li",
    { class: one.chosen ? "chosen" : null, "data-key": `candidate-${one.whisker}` },
    h(
      "div",
      { class: "who" },
      h(
        "strong",
        {},
        h("a", { href: link.whisker(names(decision, one.whisker)) }, `${decision.array} ${one.whisker}`),
        own ? " itself" : null,
      ),
      verdict,
    ),
    h(
      "p",
      { class: "hint" },
      [
        say(CASES, one.case),
        pressure,
        `length ${length}`,
        own ? null : one.gives_up_own_role ? "would lose its own place" : "keeps its own place",
      ]
        .filter(Boolean)
        .join(" \u00b7 "),
    ),
    Number.isFinite(one.predicted_error)
      ? h(
          "div",
          { class: "outlook" },
          errorPicture([
            {
              name: "predicted",
              tone: one.chosen ? "b" : "m",
              value: one.predicted_error,
              low: one.predicted_error_low,
              high: one.predicted_error_high,
            },
          ]),
          h("span", { class: "hint" }, error(one, "predicted_error")),
        )
      : null,
  );
}
