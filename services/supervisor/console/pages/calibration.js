// A calibration: its curve, its parameters, where its model is used, and its activation.

import { get, has, ifServed, list } from "../api.js";
import { calibrationChart } from "../charts/ratio.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { count, interval, time } from "../format.js";
import { mark } from "../marks.js";
import { prepared } from "../parts/bulk.js";
import { rolloutButton } from "../parts/rollouts.js";
import { api, link } from "../places.js";
import { facts, section, table, trail } from "../table.js";

/** Most versions of the model, and most activations of a fleet, among which the previous one is looked for. */
const VERSIONS = 200;

export default {
  async load({ id }) {
    const told = await get(api.calibration(id));
    const [uses, versions] = await Promise.all([
      ifServed("/v1/calibrations/{}/use", async () => (await get(`${api.calibration(id)}/use`)).items, []),
      list("/v1/calibrations", { model: told.model, limit: VERSIONS }),
    ]);
    const active = uses.filter((one) => one.is_active);
    const previous = new Map(
      await Promise.all(active.map(async ({ fleet }) => [fleet, await previousOf(fleet, told, versions)])),
    );
    return { told, uses, versions, previous };
  },

  view({ told, uses, versions, previous }, _, refresh) {
    return [
      trail(["Calibrations", link.calibrations()]),
      h("h1", { tabindex: "-1" }, `Calibration ${told.model}, version ${told.version}`),
      facts([
        ["Uploaded", time(told.uploaded_at)],
        ["Actor", told.uploaded_by],
        ["c, limit of k2 at high pressure", number(told.fit.c)],
        ["a, excess of k2 at zero pressure", number(told.fit.a)],
        ["b, rate of softening per MPa", number(told.fit.b_per_mpa, 2)],
        ["Young's modulus of the rubber", `${told.measurements.youngs_modulus_mpa}\u00a0MPa`],
        ["Scatter of single strains", `${(100 * told.fit.strain_scatter).toFixed(1)}\u00a0%`],
        ["Readings", count(told.measurements.rows.length, "reading")],
      ]),
      section("Curve", calibrationChart(told)),
      section("Where it is used", usesTable(told, uses, previous, refresh), activateInAll(told, uses, refresh)),
      section("Versions of this model", versionsTable(told, versions)),
    ];
  },
};

const number = ({ value, low, high }, digits = 4) => interval(value, low, high, (one) => one.toFixed(digits));

/** The version that was active in a fleet before this one; null if none is known. A roll-out activates its own at its end. */
async function previousOf(fleet, told, versions) {
  const [asked, rolledOut] = await Promise.all([
    ifServed("/v1/audit", () => list("/v1/audit", { fleet, kind: "CALIBRATION", state: "DONE", limit: VERSIONS }), []),
    ifServed("/v1/rollouts", () => list("/v1/rollouts", { fleet, state: "COMPLETED", limit: VERSIONS }), []),
  ]);
  const activations = [
    ...asked.map((one) => ({ at: one.done_at ?? one.asked_at, id: one.parameters.calibration_id })),
    ...rolledOut
      .filter(({ kind }) => kind === "CALIBRATION")
      .map((one) => ({ at: one.updated_at, id: one.change.calibration_id })),
  ];
  activations.sort((one, other) => Date.parse(other.at) - Date.parse(one.at));
  const others = activations.map(({ id }) => id).filter((id) => id !== told.calibration_id);
  return others.map((id) => versions.find((one) => one.calibration_id === id)).find(Boolean) ?? null;
}

function usesTable(told, uses, previous, refresh) {
  return table({
    caption: `Fleets with whiskers of model ${told.model}`,
    rows: uses,
    key: (row) => `use-${row.fleet}`,
    empty: "No robot has whiskers of this model.",
    columns: [
      { name: "Fleet", head: true, cell: (row) => h("a", { href: link.fleet(row.fleet) }, row.fleet) },
      {
        name: "This calibration",
        cell: (row) => (row.is_active ? mark("active", "good", "tick") : mark("not active", "off", "ring")),
      },
      { name: "Robots", numeric: true, cell: (row) => row.robots.toLocaleString("en") },
      {
        name: "Whiskers",
        numeric: true,
        cell: (row) =>
          h("a", { href: link.whiskers({ fleet: row.fleet, model: told.model }) }, row.whiskers.toLocaleString("en")),
      },
      { name: "Action", cell: (row) => action(told, row, previous.get(row.fleet), refresh) },
    ],
  });
}

function action(told, { fleet, is_active: isActive, whiskers }, previous, refresh) {
  if (!isActive)
    return h("span", { class: "buttons" }, activation(told, fleet, whiskers, "Activate", refresh), inStages(told, fleet, refresh));
  if (previous) return activation(previous, fleet, whiskers, `Restore version ${previous.version}`, refresh);
  return "\u2013";
}

function activation(one, fleet, whiskers, button, refresh) {
  return h(
    "span",
    { class: "buttons" },
    actionButton(
      {
        title: `${button} of ${one.model} in fleet ${fleet}`,
        what: [
          `Version ${one.version} applies to ${count(whiskers, "whisker")} of fleet ${fleet}. Their baselines are relearned at their present lengths; until then a cut is not detected. Pressures do not change.`,
        ],
        button,
        grave: true,
        reason: "optional",
        path: `${api.fleet(fleet)}/calibrations/${one.calibration_id}/activate`,
        body: (values) => ({ reason: values.reason?.trim() || undefined }),
      },
      refresh,
    ),
  );
}

/** The button that rolls the calibration out in stages. */
function inStages(told, fleet, refresh) {
  const action = {
    fleet,
    title: `Roll version ${told.version} of ${told.model} out in fleet ${fleet}`,
    what: "The baselines of the changed robots' whiskers are relearned; until then a cut is not detected.",
    change: () => ({ calibration_id: told.calibration_id }),
    words: "Roll out in stages",
  };
  return rolloutButton(action, refresh);
}

/** The button that activates the calibration in all fleets. */
function activateInAll(told, uses, refresh) {
  const path = `/v1/calibrations/${encodeURIComponent(told.calibration_id)}/activate`;
  if (uses.length < 2 || !has("POST", "/v1/calibrations/{}/activate")) return null;
  const prepare = () =>
    prepared({
      path,
      noun: "fleet",
      verb: "Activate in",
      what: [
        `Version ${told.version} applies to all whiskers of model ${told.model} in these fleets. Their baselines are relearned at their present lengths; until then a cut is not detected. Pressures do not change.`,
      ],
      grave: true,
      body: { filter: {} },
    });
  return h("div", { class: "buttons" }, actionButton({ path, prepare, grave: true }, refresh, "Activate in all fleets"));
}

function versionsTable(told, versions) {
  return table({
    caption: `Versions of ${told.model}, the newest first`,
    rows: versions,
    key: (row) => `version-${row.calibration_id}`,
    empty: "",
    columns: [
      {
        name: "Version",
        head: true,
        cell: (row) =>
          row.calibration_id === told.calibration_id
            ? `${row.version}, this one`
            : h("a", { href: link.calibration(row.calibration_id) }, String(row.version)),
      },
      { name: "Uploaded", cell: (row) => time(row.uploaded_at) },
      { name: "Active in", cell: (row) => row.active_in?.replaceAll(",", ", ") ?? "no fleet" },
    ],
  });
}
