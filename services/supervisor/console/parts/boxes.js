// Black boxes: the messages of a robot around an event, as files for `vibrissa-lab replay`.

import { ifServed, list } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { saveLink } from "../save.js";
import { table } from "../table.js";
import { ALARM_KINDS, BLACK_BOX_STATES, FAULTS, say } from "../words.js";

/** The newest boxes of a robot, at most `limit`. */
export function boxesOf({ fleet, robot }, limit) {
  return ifServed("/v1/black-boxes", () => list("/v1/black-boxes", { fleet, robot, limit }), []);
}

/** A link that saves the recording of a box; nothing without a box. */
export function boxLink(id, words = "Black box") {
  if (id === null || id === undefined) return null;
  const title = "Messages of the robot around the event";
  return saveLink(`/v1/black-boxes/${id}/recording`, `black-box-${id}.jsonl`, words, { title });
}

/** The boxes of a robot as a table. */
export function boxesTable(boxes) {
  return [
    table({
      caption: "Messages around trims, faults and alarms, the newest first",
      rows: boxes,
      key: (row) => `box-${row.black_box_id}`,
      empty: "None.",
      columns: [
        { name: "Event", head: true, cell: (row) => [cause(row), " ", time(row.event_at)] },
        { name: "Whisker", cell: (row) => h("a", { href: link.whisker(row) }, whiskerName(row)) },
        { name: "From", cell: (row) => time(row.began_at) },
        { name: "To", cell: (row) => time(row.last_at) },
        { name: "State", cell: (row) => markOf(BLACK_BOX_STATES, row.state) },
        { name: "Messages", numeric: true, cell: (row) => row.messages.toLocaleString("en") },
        { name: "File", cell: (row) => boxLink(row.black_box_id, `Save (${Math.ceil(row.bytes / 1000).toLocaleString("en")}\u00a0kB)`) },
      ],
    }),
    boxes.length ? h("p", { class: "hint" }, "Replay: ", h("code", {}, "vibrissa-lab replay FILE")) : null,
  ];
}

function cause({ cause: word }) {
  return word === "TRIM" ? "trim" : say(word in FAULTS ? FAULTS : ALARM_KINDS, word);
}
