// Notes on a robot: who wrote them and when, and the dialogs that add and remove one.

import { has, ifServed, list } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { api, ROUTES } from "../places.js";
import { section, table } from "../table.js";

const ROUTE = `${ROUTES.robot}/notes`;
/** A robot has no more notes. */
const NOTES = 100;

const pathOf = (robot) => `${api.robot(robot)}/notes`;

/** The notes on a robot, the newest first. */
export function notesOf(robot) {
  return ifServed(ROUTE, () => list(pathOf(robot), { limit: NOTES }), null);
}

/** The notes as a table, with the buttons to change them; nothing if the service has no notes. */
export function robotNotes(notes, robot, done) {
  if (!notes) return null;
  const canRemove = has("DELETE", `${ROUTE}/{}`);
  return section(
    "Notes",
    table({
      caption: "What people wrote about this robot, the newest first",
      rows: notes,
      key: (row) => `note-${row.note_id}`,
      empty: "No notes.",
      columns: [
        { name: "Written", head: true, cell: (row) => time(row.written_at) },
        { name: "Author", cell: (row) => row.author },
        { name: "Note", cell: (row) => h("span", { class: "note" }, row.text) },
        canRemove && { name: "Remove", cell: (row) => actionButton(removal(row), done, "Remove") },
      ].filter(Boolean),
    }),
    has("POST", ROUTE) ? h("div", { class: "buttons" }, actionButton(addition(robot), done)) : null,
  );
}

function addition(robot) {
  return {
    title: `Add a note to ${robot.robot}`,
    what: ["Everybody who may see the robot sees the note. The audit log keeps its text."],
    fields: [{ name: "text", label: "Note", hint: "Plain text, at most 2000 characters.", rows: 5, maxlength: 2000, required: true }],
    button: "Add a note",
    path: pathOf(robot),
    body: ({ text }) => ({ text }),
  };
}

function removal(note) {
  return {
    title: `Remove a note of ${note.robot}`,
    what: [`Note of ${note.author}:`],
    list: h("blockquote", { class: "note" }, note.text),
    button: "Remove the note",
    reason: "optional",
    method: "DELETE",
    path: `${pathOf(note)}/${note.note_id}`,
    body: ({ reason }) => ({ reason: reason?.trim() || undefined }),
  };
}
