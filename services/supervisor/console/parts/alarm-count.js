// The number of open alarms, for the menu and the title of the window.

import { has, list } from "../api.js";

const COUNTS = "/v1/alarms/counts";

/** The number of alarms that stand and are not shelved; null if the service does not tell it. */
export async function openAlarms() {
  if (!has("GET", COUNTS)) return null;
  const counts = await list(COUNTS, { open: true }).catch(() => null);
  return counts?.reduce((sum, { alarms }) => sum + alarms, 0) ?? null;
}
