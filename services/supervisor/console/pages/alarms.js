// All alarms, the standing ones first.

import { list } from "../api.js";
import { alarmActions } from "../actions.js";
import { h } from "../dom.js";
import { count, time } from "../format.js";
import { markOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { section, table } from "../table.js";
import { ALARM_KINDS, ALARM_STATES, say } from "../words.js";

const OLD = 100;

export default {
  async load() {
    const [standing, over] = await Promise.all([
      list("/v1/alarms", { standing: true }),
      list("/v1/alarms", { standing: false, limit: OLD }),
    ]);
    return { standing, over };
  },

  view({ standing, over }, _, refresh) {
    const urgency = { UNACKNOWLEDGED: 0, STANDING: 0, ACKNOWLEDGED: 1, SHELVED: 2 };
    const sorted = standing
      .map(withState)
      .sort((one, other) => urgency[one.state] - urgency[other.state] || other.raised_at.localeCompare(one.raised_at));
    const open = sorted.filter((one) => one.state === "UNACKNOWLEDGED").length;
    return [
      h("h1", { tabindex: "-1" }, "Alarms"),
      h(
        "p",
        { class: "summary" },
        standing.length
          ? `${count(standing.length, "alarm")} standing${open ? `, ${open} not acknowledged` : ""}.`
          : "No standing alarms.",
      ),
      section("Standing", alarmsTable(sorted, "Standing alarms, the most urgent first", "None.", refresh)),
      section("Cleared", alarmsTable(over.map(withState), `The newest ${OLD} cleared alarms`, "None.", refresh)),
    ];
  },
};

function withState(alarm) {
  return { ...alarm, state: alarm.state ?? (alarm.standing ? "STANDING" : "CLEARED") };
}

function alarmsTable(rows, caption, empty, refresh) {
  const actions = (row) => h("span", { class: "buttons" }, alarmActions(row, refresh));
  const canAct = rows.some((row) => alarmActions(row, refresh).length);
  const columns = [
    { name: "Alarm", head: true, cell: (row) => say(ALARM_KINDS, row.kind) },
    { name: "State", cell: state },
    {
      name: "Whisker",
      cell: (row) => h("a", { href: link.whisker(row) }, `${row.fleet}, ${row.robot}, whisker ${whiskerName(row)}`),
    },
    { name: "Raised", cell: (row) => time(row.raised_at) },
    rows.some((row) => row.cleared_at) ? { name: "Cleared", cell: (row) => time(row.cleared_at) } : null,
    canAct ? { name: "Actions", cell: actions } : null,
  ];
  return table({ caption, rows, empty, key: (row) => `alarm-${row.alarm_id}`, columns: columns.filter(Boolean) });
}

function state(alarm) {
  const by =
    {
      ACKNOWLEDGED: [alarm.acknowledged_by, alarm.acknowledged_reason],
      SHELVED: [alarm.shelved_by, alarm.shelved_reason],
    }[alarm.state] ?? [];
  const words = [by[0] && `by ${by[0]}`, by[1] && `\u201c${by[1]}\u201d`].filter(Boolean).join(": ");
  return h(
    "span",
    { class: "marks" },
    markOf(ALARM_STATES, alarm.state),
    alarm.state === "SHELVED" && alarm.shelved_until ? h("span", {}, "until ", time(alarm.shelved_until)) : null,
    words ? h("span", {}, words) : null,
  );
}
