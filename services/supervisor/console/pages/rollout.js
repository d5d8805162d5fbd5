// A staged roll-out: its stage, the comparison of changed and unchanged robots, and what happened.

import { get } from "../api.js";
import { h } from "../dom.js";
import { percent, time } from "../format.js";
import { changeOf, comparisonOf, concerned, expectedEnd, rolloutActions, rolloutMarks } from "../parts/rollouts.js";
import { api, link } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import { ROLLOUT_EVENTS, ROLLOUT_STAGES, say } from "../words.js";

export default {
  async load({ id }) {
    const found = await get(`/v1/rollouts/${encodeURIComponent(id)}`);
    const fleet = await get(api.fleet(found.rollout.fleet)).catch(() => null);
    return { ...found, robots: fleet?.robots };
  },

  view({ rollout, events, robots }, _, refresh) {
    const actions = rolloutActions(rollout, refresh);
    return [
      trail(["Policy", link.policies()], ["Roll-outs", link.rollouts()]),
      h("h1", { tabindex: "-1" }, `Roll-out ${rollout.rollout_id} of fleet ${rollout.fleet}`),
      h("p", { class: "marks" }, rolloutMarks(rollout)),
      facts([
        ["Change", changeOf(rollout)],
        ["Robots concerned", concerned(rollout, robots)],
        ["This stage ends", expectedEnd(rollout)],
        ["Measured errors in this stage", comparisonOf(rollout)],
        ["Comparisons in this stage", `${rollout.looks} of at most 3`],
        ["Probability that chance looks so much worse", rollout.probability === null ? null : percent(rollout.probability, 2)],
        ["Rolls back if the changed robots are worse", `p ≤ ${percent(rollout.level / 6, 2)}`],
        ["Changed robots that complete a stage", rollout.robots],
        ["Began", time(rollout.started_at)],
        ["Stage began", time(rollout.stage_at)],
        ["Actor", rollout.started_by],
        ["Reason", rollout.reason],
      ]),
      actions.length ? h("div", { class: "buttons" }, actions) : null,
      section("Events", eventsTable(events)),
    ];
  },
};

function eventsTable(events) {
  return table({
    caption: "What happened, the newest first",
    rows: events,
    empty: "Nothing yet.",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.at) },
      { name: "Event", cell: (row) => say(ROLLOUT_EVENTS, row.event) },
      { name: "Stage", cell: (row) => say(ROLLOUT_STAGES, row.stage) },
      { name: "Actor", cell: (row) => (row.actor === "supervisor" ? "the supervisor" : row.actor) },
      { name: "Why", cell: (row) => row.detail },
    ],
  });
}
