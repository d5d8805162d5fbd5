// Tables of what the supervisor found of a whisker: its trims, and the changes of its health.

import { interval, mm, time } from "../format.js";
import { table } from "../table.js";
import { CONDITIONS, FAULTS, say } from "../words.js";
import { boxLink } from "./boxes.js";

/** The trims of a whisker. */
export function trimsTable(trims) {
  return table({
    caption: "Detected trims, the newest first",
    rows: [...trims].sort((one, other) => other.detected_at.localeCompare(one.detected_at)),
    key: (row) => `trim-${row.trim_id}`,
    empty: "None detected.",
    columns: [
      { name: "Detected", head: true, cell: (row) => time(row.detected_at) },
      { name: "Length before", numeric: true, cell: (row) => mm(row.length_before_mm) },
      {
        name: "Length after",
        numeric: true,
        cell: (row) => interval(row.length_after_mm, row.length_after_low_mm, row.length_after_high_mm),
      },
      { name: "Contacts to detection", numeric: true, cell: (row) => row.contacts_to_detect },
      { name: "Messages", cell: (row) => boxLink(row.black_box_id) ?? "\u2013" },
    ],
  });
}

/** Changes of the health of a whisker. */
export function changesTable(changes) {
  const word = (row, value) => (value === null ? "none" : say(row.kind === "FAULT" ? FAULTS : CONDITIONS, value));
  return table({
    caption: "Changes of condition and of faults, the newest first",
    rows: [...changes].sort((one, other) => other.recorded_at.localeCompare(one.recorded_at)),
    key: (row) => `change-${row.health_change_id}`,
    empty: "None.",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.recorded_at) },
      { name: "Kind", cell: (row) => (row.kind === "FAULT" ? "fault" : "condition") },
      { name: "Before", cell: (row) => word(row, row.was) },
      { name: "After", cell: (row) => word(row, row.becomes) },
    ],
  });
}
