// Replaces the routes of actions: reports them as served, records requests to them, and answers with `window.answer`.
// All other requests go to the service.
window.sent = [];
window.answer = { status: 200, body: { action_id: 1, state: "DONE" } };
const ask = window.fetch;
const WHISKER = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}";
window.fetch = async (path, options = {}) => {
  if (options.method === "POST") {
    window.sent.push({ path, body: JSON.parse(options.body), key: options.headers["Idempotency-Key"] });
    if (!window.answer) throw new TypeError("no answer");
    return new Response(JSON.stringify(window.answer.body), {
      status: window.answer.status,
      headers: { "X-Request-Id": "request-7" },
    });
  }
  const answer = await ask(path, options);
  if (path !== "openapi.json") return answer;
  const document = await answer.json();
  for (const name of ["setpoint", "hold", "release", "replaced", "rebaseline"])
    document.paths[`${WHISKER}/${name}`] = { post: {} };
  return new Response(JSON.stringify(document));
};
