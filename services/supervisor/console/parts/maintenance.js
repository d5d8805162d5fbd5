// Windows of maintenance: alarms of these robots are shelved and notify nobody.

import { get, has, ifServed } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { section, table } from "../table.js";
import { fromField, toField, zone } from "../zone.js";

const PATH = "/v1/maintenance";
const REPEATS = { DAILY: "every day", WEEKLY: "every week" };

/** The windows that are or come; null if the service has none to offer. */
export function maintenanceOf() {
  return ifServed(PATH, async () => (await get(PATH)).items.filter((one) => one.state !== "ENDED"), null);
}

/** The present windows. */
export async function activeMaintenance() {
  return ((await maintenanceOf()) ?? []).filter((one) => one.state === "ACTIVE");
}

/** Whether one of the windows concerns a robot. */
export const isIn = (windows, { fleet, robot }) =>
  windows.some((one) => one.fleet === fleet && (one.robot === null || one.robot === robot));

const whose = ({ fleet, robot }) => (robot === null ? `all robots of ${fleet}` : `${robot} of ${fleet}`);

/** Begin, end and rhythm of a window. */
const when = (one) =>
  h("span", {}, time(one.begins_at), " to ", time(one.ends_at), one.repeats ? `, ${REPEATS[one.repeats]}` : null);

/** The window that concerns a robot now, or else the next one; null without any. */
export function maintenanceLine(windows, robot) {
  const own = (windows ?? []).filter((one) => isIn([one], robot));
  const next = own.sort((one, other) => (one.begins_at < other.begins_at ? -1 : 1))[0];
  return next ? h("span", {}, when(next), `, by ${next.set_by}: \u201c${next.reason}\u201d`) : null;
}

/** The windows as a table, with the buttons that set and end one. */
export function maintenancePart(windows, fleets, done) {
  if (!windows) return null;
  return section(
    "Maintenance",
    windows.length
      ? table({
          caption: "Alarms of these robots are shelved then, and notify nobody",
          rows: windows,
          key: (row) => `maintenance-${row.maintenance_id}`,
          empty: "",
          columns: [
            { name: "Robots", head: true, cell: whose },
            { name: "Time", cell: when },
            { name: "Reason", cell: (row) => `${row.reason} (${row.set_by})` },
            has("POST", `${PATH}/{}/end`) && { name: "End", cell: (row) => actionButton(ending(row), done, "End") },
          ].filter(Boolean),
        })
      : null,
    has("POST", PATH) ? h("div", { class: "buttons" }, actionButton(setting(fleets), done)) : null,
  );
}

function ending(row) {
  return {
    title: `End the maintenance of ${whose(row)}`,
    what: ["It does not come again. Alarms that still stand are told again."],
    button: "End the maintenance",
    reason: "optional",
    path: `${PATH}/${row.maintenance_id}/end`,
    body: ({ reason }) => ({ reason: reason?.trim() || undefined }),
  };
}

function setting(fleets) {
  const now = Date.now();
  const at = (name, label, ms) => ({
    name,
    label,
    hint: `Date and time in the time zone ${zone()}.`,
    type: "datetime-local",
    required: true,
    value: toField(ms),
  });
  return {
    title: "Set a maintenance",
    what: ["Alarms that are raised in this time are recorded and shelved. They notify nobody, and are told at its end if they still stand."],
    fields: [
      { name: "fleet", label: "Fleet", required: true, options: fleets.map((name) => [name, name]), value: fleets[0] },
      { name: "robot", label: "Robot", hint: "Empty for all robots of the fleet." },
      at("from", "From", now),
      at("until", "Until", now + 2 * 3_600_000),
      {
        name: "repeats",
        label: "Repeats",
        hint: "At the same time in UTC.",
        options: [["", "once"], ...Object.entries(REPEATS)],
        value: "",
      },
    ],
    reason: "required",
    button: "Set a maintenance",
    path: PATH,
    body: ({ fleet, robot, from, until, repeats, reason }) => ({
      fleet,
      robot: robot.trim() || null,
      from: new Date(fromField(from)).toISOString(),
      until: new Date(fromField(until)).toISOString(),
      repeats: repeats || null,
      reason: reason.trim(),
    }),
  };
}
