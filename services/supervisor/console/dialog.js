// Dialogs that show the effect of an action, and ask for its values and a reason.

import { ask, get, has, Problem } from "./api.js";
import { h } from "./dom.js";
import { follower } from "./follow.js";
import { problemPanel, refused, report } from "./notices.js";
import { identifyAgain, refusal } from "./rights.js";

/** Time for which a pending action is polled. */
const PATIENCE_MS = 15_000;
const PAUSE_MS = 500;

/**
 * A button that opens the dialog of an action. If the user's role does not allow the action, the button is disabled and
 * says why: in a tooltip, which is also its description for screen readers, and in a message when it is pressed. It can
 * still be focused; otherwise the keyboard would not reach the reason. An action with `prepare` is completed by it first.
 */
export function actionButton(action, done, words = action.button) {
  const reason = refusal(action.method ?? "POST", action.path);
  return h(
    "button",
    {
      type: "button",
      class: action.grave ? "grave" : null,
      "aria-disabled": reason ? "true" : null,
      title: reason,
      onclick: () => (reason ? refused(reason) : open(action, done)),
    },
    `${words} \u2026`,
  );
}

async function open(action, done) {
  const address = location.hash;
  try {
    const complete = action.prepare ? await action.prepare() : action;
    // The user may have left the page meanwhile: its dialog would appear on another one.
    if (location.hash === address) confirm(complete, done);
  } catch (problem) {
    report()(problem.message, "bad", true);
  }
}

/**
 * Opens the dialog of an action:
 * `{ title, what: [sentences], fields: [{ name, label, hint, type, required, .. }], reason: "optional" | "required",
 * list, button, grave, path, pathOf(values), method, headers, body(values), moves, progress(told, say), after(answer) }`. `pathOf`
 * is for paths that depend on the values. `moves` is the whisker whose pressure the action may change: its setpoint is followed
 * to the robot's answer. `progress` follows a bulk action in the same way. `after` gets the service's answer, and `done` is
 * called after the execution.
 */
function confirm(action, done) {
  const answer = h("div", { class: "answer", role: "alert" });
  const keyed = keys();
  const submit = async (event) => {
    event.preventDefault();
    const button = dialog.querySelector("button[type=submit]");
    if (button.disabled) return;
    button.disabled = true;
    answer.replaceChildren();
    try {
      const follow = action.moves ? await follower(action.moves) : null;
      const values = Object.fromEntries(new FormData(event.target));
      const path = action.pathOf?.(values) ?? action.path;
      const { isDone, told } = await carryOut({ ...action, path }, action.body(values), keyed);
      dialog.close();
      tellResult(action, isDone, follow ?? (action.progress && ((say) => action.progress(told, say))));
      done();
    } catch (problem) {
      // Another role than the page knew.
      if (problem.status === 403) identifyAgain();
      // The user may have closed the dialog meanwhile.
      if (dialog.isConnected) answer.replaceChildren(problemPanel(problem));
      else report()(`${action.title}: ${problem.message}`, "bad", true);
    } finally {
      button.disabled = false;
    }
  };
  const fields = [...(action.fields ?? []), action.reason && reasonField(action.reason === "required")].filter(Boolean);
  const dialog = h(
    "dialog",
    { "aria-labelledby": "dialog-title", onclose: () => dialog.remove() },
    h(
      "form",
      { onsubmit: submit },
      h("h2", { id: "dialog-title" }, action.title),
      action.what.map((sentence) => h("p", {}, sentence)),
      action.list ?? null,
      fields.map(field),
      answer,
      h(
        "div",
        { class: "buttons" },
        h("button", { type: "button", onclick: () => dialog.close() }, "Cancel"),
        h("button", { type: "submit", class: action.grave ? "grave" : "primary" }, action.button),
      ),
    ),
  );
  document.body.append(dialog);
  dialog.showModal();
}

function reasonField(required) {
  return { name: "reason", label: required ? "Reason" : "Reason (for the record)", required, maxlength: 500, rows: 2 };
}

/** A field with its label and hint. */
export function field({ name, label, hint, options, checks, value, rows, ...attributes }) {
  const id = `field-${name}`;
  const described = hint ? `${id}-hint` : null;
  if (checks) return checkboxes({ id, name, label, hint, checks, described });
  const common = { id, name, "aria-describedby": described, ...attributes };
  const choice = ([word, words]) => h("option", { value: word, selected: word === value }, words);
  const control = options
    ? h("select", common, options.map(choice))
    : rows
      ? h("textarea", { rows, ...common }, value ?? "")
      : h("input", { value, ...common });
  return h(
    "div",
    { class: "field" },
    h("label", { for: id }, label),
    control,
    hint ? h("p", { class: "hint", id: described }, hint) : null,
  );
}

/** Checkboxes `[word, words, isChecked]`; each checked one is a value `NAME:WORD` of the form. */
function checkboxes({ id, name, label, hint, checks, described }) {
  const one = ([word, words, isChecked]) =>
    h(
      "label",
      { class: "check" },
      h("input", { type: "checkbox", name: `${name}:${word}`, checked: isChecked }),
      h("span", {}, words),
    );
  return h(
    "fieldset",
    { class: "field", id, "aria-describedby": described },
    h("legend", {}, label),
    checks.map(one),
    hint ? h("p", { class: "hint", id: described }, hint) : null,
  );
}

/** Opens a dialog that tells something, with a button to close it. */
export function tell(title, ...content) {
  const dialog = h(
    "dialog",
    { "aria-labelledby": "told-title", onclose: () => dialog.remove() },
    h("h2", { id: "told-title" }, title),
    content,
    h("div", { class: "buttons" }, h("button", { type: "button", class: "primary", onclick: () => dialog.close() }, "Close")),
  );
  document.body.append(dialog);
  dialog.showModal();
}

/**
 * Sends requests with keys: a repeated request keeps its key, so that it is executed once. A changed one gets a new key, and so
 * does one after a final answer, which the service would repeat for its key.
 */
export function keys() {
  let [said, key] = [null, null];
  return async (request, send) => {
    const text = JSON.stringify(request);
    if (text !== said)
      [said, key] = [
        text,
        Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join(""),
      ];
    try {
      return await send({ "Idempotency-Key": key });
    } catch (problem) {
      if (problem.isFinal) said = null;
      throw problem;
    }
  };
}

/** Sends the action; returns the answer, and whether it was executed or is still pending. */
function carryOut(action, body, keyed) {
  return keyed([action.path, body], async (key) => {
    const headers = { ...action.headers, ...key };
    const answer = await ask(action.path, { method: action.method ?? "POST", headers, body });
    const told = await answer.json().catch(() => ({}));
    if (action.after) action.after(told);
    return { told, isDone: told.state !== "PENDING" || (await isSettled(told)) };
  });
}

/** Polls the action: the fleet's supervisor executes it, which may not be the one that answers. */
async function isSettled(told) {
  const until = Date.now() + PATIENCE_MS;
  while (has("GET", "/v1/actions/{}") && Date.now() < until) {
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    const now = await get(`/v1/actions/${encodeURIComponent(told.action_id)}`);
    if (now.state === "DONE") return true;
    if (now.state !== "PENDING")
      throw new Problem({ status: 409, detail: now.problem ?? `Not done: ${now.state.toLowerCase()}.` });
  }
  return false;
}

/** Shows the result; for a pressure, each answer of the robot until the last one. */
function tellResult(action, isDone, follow) {
  const tell = report();
  const say = (words, tone, isFinal) => tell(`${action.title}: ${words}.`, tone, isFinal);
  if (!isDone) say("the fleet's supervisor has not answered yet, see the audit log", "warn", true);
  else if (!follow) say("done", "good", true);
  else follow(say).catch((problem) => say(`sent, but the result is unknown: ${problem.message}`, "warn", true));
}
