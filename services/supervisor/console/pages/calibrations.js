// Calibrations of whisker models: all uploaded ones, and the upload of another one.

import { ask } from "../api.js";
import { browser } from "../browse.js";
import { readings, textOf, Unreadable } from "../calibration-file.js";
import { field, keys } from "../dialog.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { notice, problemPanel, refused } from "../notices.js";
import { link } from "../places.js";
import { refusal } from "../rights.js";
import { section } from "../table.js";

const PATH = "/v1/calibrations";
/** Largest file, in bytes: 500 readings have less than this. */
const SIZE_MAX = 200_000;

const calibrations = browser({ route: PATH, what: "calibrations", search: "model or actor" });

const COLUMNS = [
  {
    name: "Calibration",
    sort: "model",
    head: true,
    cell: (row) => h("a", { href: link.calibration(row.calibration_id) }, `${row.model}, version ${row.version}`),
  },
  {
    name: "Uploaded",
    sort: "calibration_id",
    descends: true,
    isDefault: true,
    cell: (row) => time(row.uploaded_at),
  },
  { name: "Actor", cell: (row) => row.uploaded_by },
  {
    name: "Active in",
    cell: (row) =>
      row.active_in
        ? row.active_in.split(",").map((fleet) => h("a", { href: link.fleet(fleet) }, fleet))
        : "no fleet",
  },
];

export default {
  async load(_, state) {
    return { page: await calibrations.load(state) };
  },

  view({ page }) {
    return [
      h("h1", { tabindex: "-1" }, "Calibrations"),
      h(
        "p",
        { class: "summary" },
        "Measured curves of whisker models, each with the fleets in which it is active.",
      ),
      calibrations.view(page, {
        caption: "Uploaded calibrations",
        columns: COLUMNS,
        key: (row) => `calibration-${row.calibration_id}`,
        empty: "No calibration has been uploaded yet.",
      }),
      section("Upload", h("upload-form", { "data-key": "upload" })),
    ];
  },
};

const FIELDS = [
  {
    name: "file",
    label: "File with the readings",
    hint: "CSV with a header: pressure_mpa, one of strain, strain_reading_um_per_m, strain_reading_mm_per_m, and optionally elongation_mm. Columns are separated by commas, and pressures are in MPa (100 kPa are 0.1 MPa).",
    type: "file",
    accept: ".csv,.json,text/csv,application/json",
    required: true,
  },
  {
    name: "model",
    label: "Whisker model",
    hint: "The name in the factsheets of robots: letters, digits, _ and -.",
    pattern: "[A-Za-z0-9_\\-]{1,64}",
    maxlength: 64,
    required: true,
  },
  {
    name: "youngs_modulus_mpa",
    label: "Young's modulus of the rubber, MPa",
    hint: "Strains alone determine only its product with k2. The default is that of the paper.",
    type: "number",
    min: 0,
    max: 1000,
    step: "any",
    value: 1.1134477,
    required: true,
  },
  {
    name: "gauge_factor",
    label: "Gauge factor",
    hint: "Divides readings of an instrument with a gauge factor of 1; columns named strain do not need it.",
    type: "number",
    min: 0.01,
    max: 1000,
    step: "any",
    value: 2.21,
    required: true,
  },
  { name: "reason", label: "Reason (for the record)", maxlength: 500, rows: 2 },
];

/** The form fills itself, so that new data do not remove its answer. */
class UploadForm extends HTMLElement {
  connectedCallback() {
    if (!this.firstChild) this.append(uploadForm());
  }
}

customElements.define("upload-form", UploadForm);

function uploadForm() {
  const reason = refusal("POST", PATH);
  const keyed = keys();
  return h(
    "form",
    { class: "card", id: "upload", onsubmit: submit },
    h("p", {}, "The service fits the readings and stores them as the model's next version. It is not active in any fleet yet."),
    FIELDS.map(field),
    h("div", { class: "answer", role: "alert" }),
    h(
      "div",
      { class: "buttons" },
      h("button", { type: "submit", class: "primary", "aria-disabled": reason ? "true" : null, title: reason }, "Upload"),
    ),
  );

  function submit(event) {
    event.preventDefault();
    // The form stays as it was made, but the role may have changed.
    const now = refusal("POST", PATH);
    if (now) refused(now);
    else upload(event, keyed);
  }
}

async function upload(event, keyed) {
  const form = event.currentTarget ?? event.target;
  const [answer, button] = [form.querySelector(".answer"), form.querySelector("button")];
  if (button.disabled) return;
  button.disabled = true;
  answer.replaceChildren();
  let lines = null;
  try {
    const told = Object.fromEntries(new FormData(form));
    if (told.file.size > SIZE_MAX) throw new Unreadable(`The file has more than ${SIZE_MAX / 1000} kB.`);
    const read = readings(await textOf(told.file), Number(told.gauge_factor));
    lines = read.lines;
    const body = {
      model: told.model,
      youngs_modulus_mpa: Number(told.youngs_modulus_mpa),
      rows: read.rows,
      reason: told.reason.trim() || undefined,
    };
    const answered = await keyed(body, (headers) => ask(PATH, { method: "POST", headers, body }));
    const stored = await answered.json();
    notice(`Stored as version ${stored.version} of ${stored.model}.`);
    location.hash = link.calibration(stored.calibration_id);
  } catch (problem) {
    const title = problem instanceof Unreadable ? "The file cannot be read" : problem.title;
    answer.replaceChildren(problemPanel({ ...problem, title, message: inLines(problem.message, lines) }));
  } finally {
    button.disabled = false;
  }
}

/** The service counts rows from 0; people count the lines of their file. */
function inLines(message, lines) {
  return message.replace(/rows\[(\d+)\]\.(\w+)/g, (all, row, column) =>
    lines?.[row] ? `Line ${lines[row]}, column ${column}` : all,
  );
}
