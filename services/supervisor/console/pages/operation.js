// One operation of the REST interface: parameters, body, answers, and a form that sends it if it only reads.

import { ask, operations, withQuery } from "../api.js";
import { h } from "../dom.js";
import { fieldsOf, typeOf } from "../schema.js";
import { link } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import nowhere from "./nowhere.js";

/** Characters of an answer that are shown. */
const SHOWN_MAX = 20_000;

export default {
  load: async ({ id }) => operations().find((one) => one.id === id) ?? null,

  view(operation) {
    if (!operation) return nowhere.view();
    const { method, route, summary, description, parameters, body, answers, role } = operation;
    return [
      trail(["API", link.operations()]),
      h("h1", { tabindex: "-1", class: "operation" }, `${method} ${route}`),
      h("p", { class: "summary" }, [summary, description].filter(Boolean).join(" ")),
      facts([
        ["Role", role.toLowerCase()],
        ["In a program", h("code", {}, curl(operation))],
      ]),
      parameters.length ? section("Parameters", table({ caption: "Parameters", rows: parameters.map(parameterRow), columns: FIELDS })) : null,
      body ? section("Body", fields("Fields of the body", body)) : null,
      section("Answers", answers.map(answer)),
      method === "GET" ? section("Try it", form(operation)) : null,
    ];
  },
};

const parameterRow = (one) => ({
  name: one.name,
  type: typeOf(one.schema),
  isRequired: one.required,
  description: [one.in === "path" ? "" : `(${one.in})`, one.description].filter(Boolean).join(" "),
});

const FIELDS = [
  { name: "Name", head: true, cell: (row) => h("code", {}, row.name) },
  { name: "Type", cell: (row) => row.type },
  { name: "Required", cell: (row) => (row.isRequired ? "yes" : "no") },
  { name: "Meaning", cell: (row) => row.description ?? "" },
];

function fields(caption, schema) {
  const rows = fieldsOf(schema);
  return rows.length ? table({ caption, rows, columns: FIELDS }) : h("p", {}, typeOf(schema));
}

function answer({ status, description, type, schema }) {
  return h(
    "details",
    { "data-key": `answer-${status}`, open: status.startsWith("2") },
    h("summary", {}, `${status} ${description}`),
    type ? h("p", { class: "hint" }, type) : null,
    schema ? fields(`Fields of the answer ${status}`, schema) : null,
  );
}

/** The request as a command. A service without tokens needs no header. */
function curl({ method, route, body }) {
  const address = new URL(route.slice(1), document.baseURI).href.replaceAll("%7B", "{").replaceAll("%7D", "}");
  const data = body ? " -H 'Content-Type: application/json' -d '{ }'" : "";
  return `curl -X ${method} -H "Authorization: Bearer $TOKEN"${data} '${address}'`;
}

/** Fields for the parameters, and the answer to the request. */
function form({ id, route, parameters }) {
  const shown = h("pre", { class: "answer", tabindex: "0", role: "region", "aria-label": "Answer", hidden: true });
  const send = async (event) => {
    event.preventDefault();
    const told = new FormData(event.target);
    const value = (one) => told.get(one.name) || undefined;
    const path = route.replace(/\{(\w+)\}/g, (_, name) => encodeURIComponent(told.get(name)));
    const query = Object.fromEntries(parameters.filter((one) => one.in === "query").map((one) => [one.name, value(one)]));
    const headers = { ...Object.fromEntries(parameters.filter((one) => one.in === "header" && value(one)).map((one) => [one.name, value(one)])) };
    const place = event.target.querySelector("pre");
    place.hidden = false;
    place.textContent = await received(withQuery(path, query), headers);
  };
  return h(
    "form",
    { class: "try", "data-key": `try-${id}`, onsubmit: send },
    parameters.map((one) =>
      h("label", {}, `${one.name}${one.required ? " (required)" : ""} `, h("input", { name: one.name, required: one.required, "data-key": `field-${one.name}` })),
    ),
    h("button", {}, "Send"),
    h("operation-answer", {}, shown),
  );
}

async function received(path, headers) {
  try {
    const answer = await ask(path, { headers });
    if (answer.headers.get("Content-Type")?.includes("event-stream")) {
      await answer.body?.cancel();
      return "The service streams events here: read them with a program.";
    }
    const text = await answer.text();
    let told = text;
    try {
      told = JSON.stringify(JSON.parse(text), null, 2);
    } catch {
      // Not JSON: shown as it is.
    }
    return told.length > SHOWN_MAX ? `${told.slice(0, SHOWN_MAX)}\n(cut after ${SHOWN_MAX} characters)` : told;
  } catch (problem) {
    return problem.message;
  }
}
