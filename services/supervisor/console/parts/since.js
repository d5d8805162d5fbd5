// The filter "since": a span before now in the address, and its beginning for the API.

const SPANS_MS = { "1h": 3_600_000, "24h": 86_400_000, "7d": 7 * 86_400_000, "30d": 30 * 86_400_000 };

/** The filter of a table. */
export const SINCE = {
  name: "since",
  label: "Time",
  options: [
    ["1h", "last hour"],
    ["24h", "last 24 hours"],
    ["7d", "last 7 days"],
    ["30d", "last 30 days"],
  ],
};

/** The parameters of the API for the span of an address. */
export function fromOf({ since }) {
  const span = SPANS_MS[since];
  // `since` itself is no parameter of the API.
  return { since: undefined, from: span ? new Date(Date.now() - span).toISOString() : undefined };
}
