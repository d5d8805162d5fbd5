// Messages beside the page's content: results and errors.

import { h } from "./dom.js";

const SHOWN_MS = 12_000;

/** Shows a message for a while; screen readers announce it. */
export function notice(words) {
  report()(words, "good", true);
}

/** Shows for a while why something is not done. */
export function refused(words) {
  report()(words, "warn", true);
}

/**
 * Shows a message that changes: returns `tell(words, tone, isFinal)`. The message disappears a while after its final
 * words, unless they are bad news: those stay until they are dismissed.
 */
export function report() {
  const close = h(
    "button",
    { type: "button", class: "quiet", "aria-label": "Dismiss the message", onclick: () => shown.remove() },
    "\u00d7",
  );
  const told = h("span", {});
  const shown = h("div", { class: "notice" }, told, close);
  document.getElementById("notices").append(shown);
  return (words, tone, isFinal) => {
    told.textContent = words;
    shown.className = `notice ${tone}`;
    if (isFinal && tone !== "bad") setTimeout(() => shown.remove(), SHOWN_MS);
  };
}

/** A problem with the service's texts, and the request ID for its log. */
export function problemPanel(problem, retry) {
  const title = problem.title ? `${problem.title[0].toUpperCase()}${problem.title.slice(1)}` : "Something went wrong";
  return h(
    "div",
    { class: "problem" },
    h("p", {}, h("strong", {}, title, ". "), problem.message),
    problem.requestId ? h("p", { class: "hint" }, "Request ", h("code", {}, problem.requestId)) : null,
    retry ? h("button", { type: "button", onclick: retry }, "Try again") : null,
  );
}
