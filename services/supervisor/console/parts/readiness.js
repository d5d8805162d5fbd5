// Why the supervisor that serves this page does not keep its promises to robots, and what people must know besides.

import { h } from "../dom.js";
import { mark } from "../marks.js";
import { token } from "../session.js";

/** The content of `/readyz`; null for people who may not see all fleets. */
export async function readiness() {
  const headers = token() ? { Authorization: `Bearer ${token()}` } : {};
  const answer = await fetch("readyz", { headers, cache: "no-store" }).catch(() => null);
  return answer && (answer.ok || answer.status === 503) ? answer.json().catch(() => null) : null;
}

/** The reasons why it is not ready, and the notices; nothing without any. */
export function shortcomings(ready) {
  const all = [
    ...(ready?.reasons ?? []).map((text) => mark(text, "bad", "cross")),
    ...(ready?.notices ?? []).map((text) => mark(text, "warn", "diamond")),
  ];
  return all.length ? h("p", { class: "marks", role: "status" }, all) : null;
}
