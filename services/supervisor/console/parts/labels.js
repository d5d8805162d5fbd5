// Labels of robots: chips, the filter by label, and the dialogs that set and remove one.

import { has } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { api, link, ROUTES } from "../places.js";

const ROUTE = `${ROUTES.robot}/labels/{}`;

/** The filter of tables whose rows have a robot. */
export const LABEL_FILTER = { name: "label", label: "Label", text: true, maxlength: 400, placeholder: "key or key=value" };

/** The column of tables whose rows have a robot. */
export const LABEL_COLUMN = { name: "Labels", cell: (row) => labelChips(row.labels) };

/** Labels as chips, each of which leads to the whiskers with the same label. */
export function labelChips(labels) {
  const known = Object.entries(labels ?? {});
  if (!known.length) return "\u2013";
  const chip = ([key, value]) => {
    const label = `${key}=${value}`;
    return h("li", {}, h("a", { class: "label", title: label, href: link.whiskers({ label }) }, label));
  };
  return h("ul", { class: "labels" }, known.map(chip));
}

/** The buttons that change the labels of a robot. */
export function labelActions(robot, done) {
  const keys = Object.keys(robot.labels ?? {});
  return [
    has("PUT", ROUTE) ? actionButton(setting(robot), done) : null,
    keys.length && has("DELETE", ROUTE) ? actionButton(removal(robot, keys), done) : null,
  ].filter(Boolean);
}

const at = (robot, key) => `${api.robot(robot)}/labels/${encodeURIComponent(key)}`;
const reasonOf = (values) => values.reason?.trim() || undefined;

function setting(robot) {
  return {
    title: `Set a label of ${robot.robot}`,
    what: ["Labels group robots for filters, for the board and for bulk actions. They change nothing at the robot."],
    fields: [
      {
        name: "key",
        label: "Key",
        hint: "Small letters, digits and . _ -, for example hall. A key that exists gets the new value.",
        required: true,
        maxlength: 40,
        pattern: "[a-z][a-z0-9_.\\-]*",
      },
      { name: "value", label: "Value", hint: "At most 64 characters, without commas.", required: true, maxlength: 64 },
    ],
    button: "Set a label",
    reason: "optional",
    method: "PUT",
    path: at(robot, "key"),
    pathOf: ({ key }) => at(robot, key.trim()),
    body: (values) => ({ value: values.value.trim(), reason: reasonOf(values) }),
  };
}

function removal(robot, keys) {
  return {
    title: `Remove a label of ${robot.robot}`,
    what: ["Filters by this label do not find the robot any more."],
    fields: [
      { name: "key", label: "Label", options: keys.map((key) => [key, `${key}=${robot.labels[key]}`]), required: true },
    ],
    button: "Remove a label",
    reason: "optional",
    method: "DELETE",
    path: at(robot, "key"),
    pathOf: ({ key }) => at(robot, key),
    body: (values) => ({ reason: reasonOf(values) }),
  };
}
