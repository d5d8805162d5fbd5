// The token of the user, stored only in this tab until it is closed.

import { h } from "./dom.js";

const KEY = "vibrissa-token";

/** The token, if the user has signed in. */
export function token() {
  return sessionStorage.getItem(KEY);
}

/** Deletes the token. */
export function signOut() {
  sessionStorage.removeItem(KEY);
}

/** The sign-in form; `done` is called after a token was entered. */
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
      "This service requires a token. An administrator can create one: ",
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
      h("p", { class: "hint" }, "The token is stored only in this tab, until you sign out or close it."),
      h("button", { type: "submit", class: "primary" }, "Sign in"),
    ),
  ];
}
