// The demo's panel: lets incidents happen to simulated whiskers. Other services do not offer its route.

import { ask, has } from "../api.js";
import { h } from "../dom.js";
import { refused, report } from "../notices.js";
import { whiskerName } from "../places.js";
import { refusal } from "../rights.js";
import { section } from "../table.js";

const ROUTE = "/demo/incidents";
const CHOICE = "demo-whisker";

const INCIDENTS = [
  ["Cut 5 mm", { kind: "CUT", by_mm: 5 }],
  ["Cut 22 mm", { kind: "CUT", by_mm: 22 }],
  ["Wear off", { kind: "ERODE" }],
  ["Leak", { kind: "LEAK" }],
  ["Heat by 10 K", { kind: "HEAT", by_k: 10 }],
  ["Replace", { kind: "REPLACE" }],
];

/** The panel for some whiskers of a robot; null if the service is no demo. */
export function incidents(whiskers, done) {
  if (!whiskers.length || !has("POST", ROUTE)) return null;
  const chosen = () => whiskers[document.getElementById(CHOICE)?.value ?? 0];
  return section(
    "Demo",
    h(
      "p",
      {},
      "This robot is simulated. Let something happen to a whisker, and see how the supervisor finds it, decides, and measures the result. A cut takes some seconds to be found. Heat changes all whiskers of the array, and must not be taken for a cut.",
    ),
    whiskers.length > 1 ? choice(whiskers) : null,
    h(
      "div",
      { class: "buttons" },
      INCIDENTS.map(([words, incident]) => button(words, () => cause(chosen(), incident, done))),
    ),
  );
}

function choice(whiskers) {
  return h(
    "div",
    { class: "field" },
    h("label", { for: CHOICE }, "Whisker"),
    h(
      "select",
      { id: CHOICE },
      whiskers.map((whisker, index) => h("option", { value: index }, whiskerName(whisker))),
    ),
  );
}

function button(words, onclick) {
  const reason = refusal("POST", ROUTE);
  return h(
    "button",
    {
      type: "button",
      "aria-disabled": reason ? "true" : null,
      title: reason,
      onclick: () => (reason ? refused(reason) : onclick()),
    },
    words,
  );
}

async function cause({ robot, array, whisker }, incident, done) {
  const tell = report();
  try {
    const answer = await ask(ROUTE, { method: "POST", body: { robot, array, whisker, ...incident } });
    const { told } = await answer.json();
    tell(`${told[0].toUpperCase()}${told.slice(1)}.`, "good", true);
    done();
  } catch (problem) {
    tell(problem.message, "bad", true);
  }
}
