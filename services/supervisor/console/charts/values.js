// The values of charts as tables, which are filled when they are opened.

import { h } from "../dom.js";
import { interval, mm, moment, mpa, percent } from "../format.js";
import { table } from "../table.js";

/** Maximum number of rows: a shorter range shows others. */
const ROWS = 200;

const orNone = (value, say) => (Number.isFinite(value) ? say(value) : "\u2013");

export class ValueTables {
  #body = h("div", {});
  #shown = null;
  element = h(
    "details",
    { class: "value-tables", ontoggle: () => this.#fill() },
    h("summary", {}, "Values as tables"),
    this.#body,
  );

  show(found, window) {
    this.#shown = [found, window];
    this.#fill();
  }

  #fill() {
    if (!this.element.open || !this.#shown) return;
    const [{ rows, errors }, { from, to }] = this.#shown;
    const newest = (all) =>
      all
        .filter(({ at }) => at >= from && at <= to)
        .reverse()
        .slice(0, ROWS);
    this.#body.replaceChildren(contactsTable(newest(rows)), errorsTable(newest(errors)));
  }
}

const when = { name: "Time", head: true, cell: (row) => moment(row.at) };

function contactsTable(rows) {
  return table({
    caption: `Contacts in this range, the newest first, at most ${ROWS} rows`,
    rows,
    empty: "No contacts in this range.",
    columns: [
      when,
      { name: "Contacts", numeric: true, cell: (row) => row.contacts },
      {
        name: "Measured / predicted",
        numeric: true,
        cell: (row) => orNone(row.agreement, (value) => value.toFixed(3)),
      },
      { name: "Strain per mm", numeric: true, cell: (row) => orNone(row.perMm, (value) => value.toFixed(5)) },
      { name: "Length", numeric: true, cell: (row) => interval(row.length, row.low, row.high, mm) },
      { name: "Pressure", numeric: true, cell: (row) => mpa(row.pressure) },
      {
        name: "Temperature",
        numeric: true,
        cell: (row) => orNone(row.temperature, (value) => `${value.toFixed(1)}\u00a0\u00b0C`),
      },
    ],
  });
}

function errorsTable(rows) {
  return table({
    caption: `Errors in this range, the newest first, at most ${ROWS} rows`,
    rows,
    empty: "No errors in this range.",
    columns: [
      when,
      { name: "Error", numeric: true, cell: (row) => interval(row.error, row.low, row.high, percent) },
      { name: "Error with gain", numeric: true, cell: (row) => percent(row.withGain) },
      { name: "Error by air alone", numeric: true, cell: (row) => percent(row.air) },
    ],
  });
}
