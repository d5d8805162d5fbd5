// Client of the API. Errors are a `Problem` with the service's own texts.

import { token } from "./session.js";

/** An error of the API, or the reason why it could not be reached. */
export class Problem extends Error {
  constructor({ status = 0, type = "", title = "", detail = "", request_id = null, errors = [] }) {
    super(detail || title || `the service answered ${status}`);
    Object.assign(this, { status, type, title, requestId: request_id, errors });
  }

  /** Whether there was no answer. */
  get isSilence() {
    return this.status === 0;
  }

  /** Whether the same request may get another answer soon: the service or a proxy before it cannot answer now. */
  get isPassing() {
    return this.status === 429 || this.status >= 500;
  }

  /** Whether the service has decided about the request: the same one with the same key gets the same answer. */
  get isFinal() {
    const isRefusal = this.status >= 400 && this.status < 500 && ![401, 408, 429].includes(this.status);
    return isRefusal || this.type.endsWith("/problems/not-supervised");
  }
}

/** A path of the API; each value becomes one encoded segment. */
export function path(strings, ...values) {
  return String.raw({ raw: strings }, ...values.map((value) => encodeURIComponent(value)));
}

/** A path with the known values of a query. */
export function withQuery(path, query) {
  const told = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== null);
  return told.length ? `${path}?${new URLSearchParams(told)}` : path;
}

/** Time in which an answer must begin: the service itself needs 20 s at most. */
const ANSWER_MS = 30_000;

/** Sends a request; returns a successful answer or throws a `Problem`. */
export async function ask(path, { method = "GET", headers = {}, body, signal } = {}) {
  const all = { ...headers };
  if (token()) all.Authorization = `Bearer ${token()}`;
  if (body !== undefined) all["Content-Type"] = "application/json";
  let answer;
  const limit = new AbortController();
  const timer = setTimeout(() => limit.abort(), ANSWER_MS);
  const either = signal ? AbortSignal.any([signal, limit.signal]) : limit.signal;
  try {
    const text = body === undefined ? undefined : JSON.stringify(body);
    answer = await fetch(path.replace(/^\//, ""), { method, headers: all, body: text, signal: either, cache: "no-store" });
  } catch (problem) {
    if (signal?.aborted) throw problem;
    throw new Problem({ detail: "The service does not answer." });
  } finally {
    clearTimeout(timer);
  }
  if (answer.ok) return answer;
  const told = await answer.json().catch(() => ({}));
  throw new Problem({ request_id: answer.headers.get("X-Request-Id"), ...told, status: answer.status });
}

/** The JSON of a GET. */
export async function get(path, query, options) {
  return (await ask(withQuery(path, query), options)).json();
}

/** The text of a GET, for example of a plot. */
export async function text(path, query, options) {
  return (await ask(withQuery(path, query), options)).text();
}

/** The rows of a list's first pages. */
export async function list(path, query = {}, pages = 5) {
  const items = [];
  let cursor;
  for (let page = 0; page < pages; page += 1) {
    const { items: more, next_cursor: next } = await get(path, { limit: 1000, ...query, cursor });
    items.push(...more);
    if (!next || query.limit) break;
    cursor = next;
  }
  return items;
}

let served = null;
let schemas = {};

/** Reads the service's routes and schemas from its OpenAPI document; missing routes are not offered. */
export async function learn() {
  if (served) return;
  const { paths, components } = await get("/openapi.json");
  schemas = components?.schemas ?? {};
  const routes = new Map();
  for (const [path, item] of Object.entries(paths)) {
    for (const [word, operation] of Object.entries(item)) {
      const method = word.toUpperCase();
      routes.set(`${method} ${shape(path)}`, { ...operation, method, route: path });
    }
  }
  served = routes;
}

function shape(path) {
  return path.replace(/\{[^}]*\}/g, "{}");
}

/** All operations of the service's document, in its order. */
export function operations() {
  return [...(served ?? [])].map(([, told]) => {
    const content = (one) => Object.entries(one?.content ?? {})[0] ?? [];
    const answers = Object.entries(told.responses).map(([status, one]) => {
      const [type, { schema } = {}] = content(one);
      return { status, description: one.description, type, schema };
    });
    return {
      id: told.operationId,
      method: told.method,
      route: told.route,
      subject: told.tags?.[0] ?? "others",
      summary: told.summary ?? "",
      description: told.description ?? "",
      role: told["x-required-role"],
      parameters: told.parameters ?? [],
      body: content(told.requestBody)[1]?.schema,
      answers,
    };
  });
}

/** Whether a route exists, for example `has("POST", "/v1/compensations/{}/approve")`. */
export function has(method, route) {
  return served?.has(`${method} ${shape(route)}`) ?? false;
}

/** Whether a list has a parameter of its query, for example `takes("/v1/audit", "format")`. */
export function takes(route, name) {
  return served?.get(`GET ${shape(route)}`)?.parameters?.some((one) => one.name === name) ?? false;
}

/** The role that a request requires, by the service's document; undefined for an unknown route. */
export function requiredRole(method, path) {
  const told = path.split("/");
  const isTold = (route) => {
    const parts = route.split("/");
    return parts.length === told.length && parts.every((part, index) => part === "{}" || part === told[index]);
  };
  for (const [route, operation] of served ?? []) {
    const [verb, shape] = route.split(" ");
    if (verb === method && isTold(shape)) return operation["x-required-role"];
  }
  return undefined;
}

/** A schema of the OpenAPI document by its name. */
export function schema(name) {
  return schemas[name];
}

/** The result of `ask` if the route exists, otherwise `instead`. */
export function ifServed(route, ask, instead = null) {
  return has("GET", route) ? ask() : Promise.resolve(instead);
}
