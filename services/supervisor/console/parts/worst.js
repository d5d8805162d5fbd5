// Beside the board: the worst whiskers with magnitude and age, the distribution of errors, and the changes of a day.

import { h } from "../dom.js";
import { age, mm, percent } from "../format.js";
import { isUncompensated } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { section } from "../table.js";
import { CONDITIONS, FAULTS, ROBOT_STATES, say } from "../words.js";
import { distribution, spark } from "./spark.js";

/** Whiskers that are shown at once; the others can be opened. */
const SHOWN = 12;
/** On the page of a fleet its list follows, so that fewer leave no gap. */
const SHOWN_OF_FLEET = 6;

/** The parts beside a board. The changes are of the fleets, so a part of them has none. */
export function aside(told, fleet, isPart) {
  return h(
    "div",
    { class: "beside-board" },
    section("Worst whiskers", worst(told.whiskers, fleet)),
    section("Errors of compensations", distribution(told.errors)),
    isPart ? null : section("Last 24 hours", changes(told.changes, fleet)),
  );
}

function worst(whiskers, fleet) {
  if (!whiskers.length) return h("p", { class: "empty" }, "All whiskers are well.");
  const rows = whiskers.map((whisker) => row(whisker, fleet));
  const shown = fleet ? SHOWN_OF_FLEET : SHOWN;
  const rest = rows.length - shown;
  return [
    h("ol", { class: "worst" }, rows.slice(0, shown)),
    rest > 0
      ? h(
          "details",
          { "data-key": "more-whiskers" },
          h("summary", {}, `${rest} more`),
          h("ol", { class: "worst", start: shown + 1 }, rows.slice(shown)),
        )
      : null,
  ];
}

/** The state of a whisker as one of a robot, and how bad it is. */
function judged(whisker) {
  const lost = `\u2212${mm(Math.max(0, whisker.lost_mm), 1)}`;
  if (isUncompensated(whisker)) return ["UNCOMPENSATED", lost];
  // The whiskers of a robot that is not heard have no fault of their own.
  const isUnheard = whisker.fault === "STALE" && whisker.connection !== "ONLINE";
  if (whisker.fault && !isUnheard) return ["FAULTY", say(FAULTS, whisker.fault)];
  if (whisker.condition !== "TRIMMED") return ["WORN", `${say(CONDITIONS, whisker.condition)} ${lost}`];
  return ["COMPENSATED", whisker.error === null ? lost : `error ${percent(whisker.error, 0)}`];
}

function row(whisker, fleet) {
  const [state, magnitude] = judged(whisker);
  const [words, tone, letter] = ROBOT_STATES[state];
  const who = fleet ? whisker.robot : `${whisker.fleet}, ${whisker.robot}`;
  const away = whisker.connection === "ONLINE" ? "" : `, ${ROBOT_STATES[whisker.connection]?.[0] ?? whisker.connection}`;
  return h(
    "li",
    { "data-key": `worst-${whisker.fleet}-${whisker.robot}-${whisker.array}-${whisker.whisker}` },
    h(
      "a",
      { href: link.whisker(whisker), title: `${whiskerName(whisker)} of ${who}${away}: ${words}, ${magnitude}` },
      h("span", { class: `tile ${tone}`, "aria-hidden": "true" }, letter),
      h("span", { class: "name" }, whiskerName(whisker), " ", h("small", {}, `${who}${away}`)),
      h("span", { class: "unseen" }, ` ${words} `),
      h("strong", { class: "magnitude" }, magnitude),
      h("small", {}, whisker.since ? age(whisker.since) : null),
    ),
  );
}

function changes(told, fleet) {
  const since = { since: "24h", fleet };
  const rows = [
    [told.trims, "trim", "found", link.trims(since)],
    [told.alarms, "alarm", "raised", link.alarms(since)],
    [told.setpoints_applied, "setpoint", "applied", link.setpoints({ ...since, state: "APPLIED" })],
    [told.whiskers_replaced, "whisker", "replaced", link.audit({ ...since, kind: "REPLACED", state: "DONE" })],
  ];
  const item = ([hours, one, done, href]) => {
    const many = hours.reduce((sum, changes) => sum + changes, 0);
    const words = `${many === 1 ? one : `${one}s`} ${done}`;
    return h(
      "li",
      { "data-key": one },
      h(
        "a",
        { href },
        h("strong", {}, many.toLocaleString("en")),
        h("span", {}, ` ${words}`),
        spark(hours, `${words}, by hour`),
      ),
    );
  };
  return h("ul", { class: "changes" }, rows.map(item));
}
