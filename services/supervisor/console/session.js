// Who is asking: a token, kept in this tab only until it is closed.

import { h } from "./dom.js";

const KEY = "vibrissa-token";

/** The token, if somebody has signed in. */
export function token() {
  return sessionStorage.getItem(KEY);
}

/** Forgets it. */
export function signOut() {
  sessionStorage.removeItem(KEY);
}

/** The form that asks for a token; `done` is called when there is a new one. */
export function signInForm(problem, done) {
  const submit = (event) => {
    event.preventDefault();
    const told = new FormData(event.target).get("token").trim();
    if (!told) return;
    sessionStorage.setItem(KEY, told);
    done();
  };
  return [
    h("h1", { tabindex: "-1" }, "Sign in"),
    h(
      "p",
      {},
      "This service asks for a token. An administrator makes one for you: ",
      h("code", {}, "vibrissa token create --help"),
      ".",
    ),
    token() ? h("p", { class: "problem", role: "alert" }, problem.message) : null,
    h(
      "form",
      { class: "card", onsubmit: submit },
      h("label", { for: "token" }, "Token"),
      h("input", {
        id: "token",
        name: "token",
        type: "password",
        autocomplete: "current-password",
        required: true,
        spellcheck: "false",
      }),
      h("p", { class: "hint" }, "It is kept in this tab only, until you sign out or close it."),
      h("button", { type: "submit", class: "primary" }, "Sign in"),
    ),
  ];
}
