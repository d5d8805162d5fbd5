// The user: name, role, and the requests that the role allows.

import { get, requiredRole, schema } from "./api.js";
import { h } from "./dom.js";
import { time } from "./format.js";

/** An expiry of a token or a session that is nearer than this is shown. */
const NEAR_MS = { token: 7 * 86_400_000, session: 3_600_000 };

/** An answer that is older than this is asked for again: a person's role can change while a page is open. */
const FRESH_MS = 60_000;

let me = null;
/** Time of the answer, ms since 1970. */
let askedAt = 0;

/** Asks the service who the user is, unless that is known. */
export async function identify() {
  if (me && Math.abs(Date.now() - askedAt) < FRESH_MS) return;
  me = await get("/v1/me");
  askedAt = Date.now();
}

/** Makes the next page ask the service again: it has refused what the known role allows. */
export function identifyAgain() {
  askedAt = 0;
}

/** Forgets the user, before another one signs in. */
export function forget() {
  me = null;
}

/** Whether the user is known. */
export function isKnown() {
  return me !== null;
}

/** Whether the user has signed in with the identity provider. */
export function isSession() {
  return me?.authentication === "SESSION";
}

/** Why the user's role does not allow a request; null if it does. */
export function refusal(method, path) {
  const needed = requiredRole(method, path);
  const roles = schema("Role")?.enum ?? [];
  if (!me || !needed || roles.indexOf(me.role) >= roles.indexOf(needed)) return null;
  return `This requires the role ${needed.toLowerCase()}. Your role is ${me.role.toLowerCase()}.`;
}

/** Name and role for the header; empty before the user is known. */
export function badge() {
  if (!me) return [];
  const fleets = me.fleets ? `Fleets: ${me.fleets.join(", ") || "none"}.` : "All fleets.";
  const expires = me.expires_at ? Date.parse(me.expires_at) : NaN;
  const isNear = expires - Date.now() < (isSession() ? NEAR_MS.session : NEAR_MS.token);
  return [
    h("span", { title: `${me.actor} in the audit log. ${fleets}` }, h("strong", {}, me.name), `, ${me.role.toLowerCase()}`),
    isNear ? h("span", { class: "hint" }, " until ", time(me.expires_at)) : null,
  ].filter(Boolean);
}
