// Notifications of the browser about new alarms, while the console is open but not in sight. Each browser chooses for
// itself; mails reach people whose console is closed. Robots in maintenance cause none.

import { activeMaintenance, isIn } from "./parts/maintenance.js";
import { ALARM_KINDS, say } from "./words.js";

const KEY = "vibrissa-notify";
/** Alarms within this time make one notification. */
const GATHER_MS = 3_000;
/** Alarms that a notification names. */
const NAMED_MAX = 3;

const isOffered = () => typeof Notification === "function";

/** Whether new alarms are notified. */
export function isOn() {
  try {
    return isOffered() && Notification.permission === "granted" && localStorage.getItem(KEY) === "on";
  } catch {
    return false;
  }
}

let waiting = [];
/** Alarms that were notified since the page was last in sight. */
let unseen = [];

/** Takes an event of the service's stream; a new alarm that is more than a warning becomes a notification. */
export function heard({ event, data }) {
  if (event !== "change" || !isOn() || !document.hidden) return;
  const { type, data: told } = JSON.parse(data);
  if (type !== "ALARM_RAISED" || told.level === "WARNING") return;
  if (!waiting.length) setTimeout(tell, GATHER_MS);
  waiting.push(told);
}

async function tell() {
  const raised = waiting;
  waiting = [];
  // Without an answer it is better to tell too much.
  const windows = await activeMaintenance().catch(() => []);
  const alarms = raised.filter((alarm) => !isIn(windows, alarm));
  if (!alarms.length) return;
  unseen = [...alarms, ...unseen];
  const line = ({ robot, array, whisker, alarm }) =>
    `${robot}${array ? ` ${array} ${whisker}` : ""}: ${say(ALARM_KINDS, alarm.kind)}`;
  const more = unseen.length > NAMED_MAX ? [`and ${unseen.length - NAMED_MAX} more`] : [];
  const body = [...unseen.slice(0, NAMED_MAX).map(line), ...more].join("\n");
  notify(unseen.length === 1 ? "New alarm" : `${unseen.length} new alarms`, body);
}

/** Replaces the notification before, with a signal of its own. */
function notify(title, body) {
  const shown = new Notification(title, { body, icon: "console/icon.svg", tag: "vibrissa-alarms", renotify: true });
  shown.onclick = () => {
    focus();
    location.hash = "#/alarms";
    shown.close();
  };
}

/** Says that no alarm is notified any more, because the session has ended. */
export function tellSignedOut() {
  if (isOn() && document.hidden) notify("Signed out", "Sign in again: until then no alarm is notified.");
}

/** Makes a button that switches the notifications; a browser without them hides it. */
export function startNotifications(button) {
  button.hidden = !isOffered();
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) unseen = [];
  });
  const show = () => {
    button.setAttribute("aria-pressed", String(isOn()));
    button.textContent = isOn() ? "Notifications of alarms: on" : "Notify me of alarms";
  };
  button.addEventListener("click", async () => {
    const next = isOn() ? "off" : "on";
    const answer = next === "on" ? await Notification.requestPermission() : "granted";
    try {
      localStorage.setItem(KEY, answer === "granted" ? next : "off");
    } catch {
      // A browser that stores nothing sends no notifications.
    }
    show();
    if (answer === "denied") button.textContent = "This browser blocks notifications of this page";
  });
  if (isOffered()) show();
}
