// The user's credential: a token, stored only in this tab until it is closed, or a session after signing in with the
// identity provider, whose cookie no script can read.

import { stateOf } from "./address.js";
import { h } from "./dom.js";

const KEY = "vibrissa-token";

/** The token, if the user has signed in. */
export function token() {
  return sessionStorage.getItem(KEY);
}

/** Deletes the token, or ends the session; returns where to sign out at the identity provider, if there. Throws if it stands. */
export async function signOut(isSession) {
  sessionStorage.removeItem(KEY);
  if (!isSession) return null;
  const answer = await fetch("auth/sign-out", { method: "POST", cache: "no-store" }).catch(() => null);
  const told = await answer?.json().catch(() => null);
  if (!answer?.ok) throw new Error(told?.detail ?? "the service does not answer");
  return told?.end_session_url;
}

/** Whether the service offers the sign-in with an identity provider. */
export async function offersSignIn() {
  const answer = await fetch("auth/options", { cache: "no-store" }).catch(() => null);
  return answer?.ok ? (await answer.json()).sign_in : false;
}

/** Why a sign-in failed, by the word in the address. */
const CAUSES = {
  CANCELLED: "The sign-in was cancelled.",
  EXPIRED: "The sign-in took too long or was begun in another browser. Sign in again.",
  NO_ROLE: "Your account has no role in this service. Ask an administrator for one.",
  PROVIDER: "The identity provider did not answer as expected. Try again later; the service's log has the reason.",
};

function complaint(problem, wasKnown) {
  if (token() || wasKnown) return `${problem.message[0].toUpperCase()}${problem.message.slice(1)}.`;
  return CAUSES[stateOf(location.hash).sign_in] ?? null;
}

/** Address of the sign-in with the identity provider, which leads back to this page. */
function signInAddress() {
  const to = location.hash.replace(/[?&]sign_in=[A-Z_]*/, "") || "#/fleets";
  return `auth/sign-in?to=${encodeURIComponent(to)}`;
}

/** The sign-in form; `done` is called after a token was entered. `wasKnown`: whether somebody was signed in before. */
export function signInForm(problem, { isOffered, wasKnown }, done) {
  const submit = (event) => {
    event.preventDefault();
    const told = new FormData(event.target).get("token").trim();
    if (!told) return;
    sessionStorage.setItem(KEY, told);
    done();
  };
  const told = complaint(problem, wasKnown);
  return [
    h("h1", { tabindex: "-1" }, "Sign in"),
    told ? h("p", { class: "problem", role: "alert" }, told) : null,
    isOffered
      ? h(
          "div",
          { class: "card", id: "sign-in" },
          h("p", {}, "Sign in with your account at the identity provider."),
          h("p", {}, h("a", { class: "button primary", href: signInAddress() }, "Sign in with your account")),
        )
      : null,
    isOffered
      ? h("details", {}, h("summary", {}, "Use a token instead"), tokenForm(submit))
      : [tokenHint(), tokenForm(submit)],
  ];
}

function tokenHint() {
  return h(
    "p",
    {},
    "This service requires a token. An administrator can create one: ",
    h("code", {}, "vibrissa token create --help"),
    ".",
  );
}

function tokenForm(submit) {
  return h(
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
  );
}
