// Actions on all robots or whiskers that the filters show: buttons, the dialog with the list of a dry run, and the progress.

import { ask, get, has } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { link, whiskerName } from "../places.js";
import { menu } from "./menu.js";

const LOOKS_MAX = 600;
const PAUSE_MS = 500;

const reasonOf = (values) => values.reason?.trim() || undefined;

const ROBOTS = {
  hold: {
    verb: "Hold",
    what: "No whisker of these robots gets automatic setpoints until the robots are released. Pressures do not change.",
  },
  release: {
    verb: "Release",
    what: "Automatic setpoints are sent again: robots may change pressures. Whiskers that are held individually stay held.",
  },
};

const WHISKERS = {
  hold: {
    verb: "Hold",
    what: "These whiskers get no automatic setpoints, and no decisions are made about them, until they are released. Pressures do not change.",
  },
  release: {
    verb: "Release",
    what: "The supervisor takes over again, also of whiskers that their robot has vented: chambers return to the pressure of their compensation, or to their nominal pressure.",
  },
  rebaseline: {
    verb: "Relearn",
    what: "Offset, noise and baseline are learned from the next contacts; the estimated lengths stay. Until then a cut is not detected.",
    grave: true,
  },
};

/** A menu for all robots that the filter selects, on all pages; `many` is their number, null if it is unknown. */
export const robotsActions = (filter, many, done) => buttons("/v1/robots", "robot", ROBOTS, { filter, many }, done);

/** A menu for all whiskers that the filter selects, on all pages. */
export const whiskersActions = (filter, many, done) => buttons("/v1/whiskers", "whisker", WHISKERS, { filter, many }, done);

/** A button to release the whiskers of the alarms VENTED that the filter of alarms shows. */
export function ventedAction({ fleet, robot, array, label, q }, done) {
  const path = "/v1/whiskers/release";
  const filter = { fleet, robot, array, label, q, vented: true };
  const { verb, what } = WHISKERS.release;
  const prepare = () => prepared({ path, noun: "whisker", verb, what: [what], body: { filter } });
  return actionButton({ path, prepare }, done, "Release all vented");
}

function buttons(route, noun, actions, { filter, many }, done) {
  const offered = Object.entries(actions).filter(([one]) => has("POST", `${route}/${one}`));
  if (!offered.length) return null;
  const button = ([one, { verb, what, grave }]) => {
    const path = `${route}/${one}`;
    const prepare = () => prepared({ path, noun, verb, what: [what], grave, body: { filter } });
    const whom = many === null ? `all ${noun}s of these filters` : count(many, noun);
    return actionButton({ path, prepare, grave }, done, `${verb} ${whom}`);
  };
  return h("div", { class: "buttons at-once" }, menu("Bulk actions", offered.map(button)));
}

/**
 * The dialog of a bulk action, after its dry run: `{ path, noun, verb, what, grave, body, fields, values }`. `body` is that of
 * the request, and `values(told)` adds what the fields say.
 */
export async function prepared({ path, noun, verb, what, grave, body, fields = [], values = () => ({}) }) {
  const answer = await ask(path, { method: "POST", body: { ...body, dry_run: true } });
  const { subjects, items, more, digest } = await answer.json();
  const title = `${verb} ${count(subjects, noun)}`;
  const reason = (told) => (fields.length ? {} : { reason: reasonOf(told) });
  return {
    title,
    what: subjects ? what : [`No ${noun} that the filters show can be concerned.`],
    list: subjects ? concerned(items, more, noun) : null,
    fields: subjects ? fields : [],
    button: subjects ? verb : "Nothing to do",
    reason: "optional",
    grave,
    path,
    body: (told) => ({ ...body, ...reason(told), ...values(told), digest }),
    progress: (told, say) => follow(told.action_id, say),
  };
}

const nameOf = ({ fleet, robot, array, whisker }) =>
  robot === null ? fleet : array === null ? `${fleet}, ${robot}` : `${fleet}, ${robot}, whisker ${whiskerName({ array, whisker })}`;

/** The subjects that a dry run found, in a box. */
function concerned(items, more, noun) {
  return [
    h(
      "div",
      { class: "concerned", role: "region", "aria-label": `All ${noun}s concerned`, tabindex: "0" },
      h("ol", {}, items.map((one) => h("li", {}, nameOf(one)))),
    ),
    more ? h("p", { class: "hint" }, "More match: repeat this for them.") : null,
  ];
}

/** Tells the progress of a request until no action waits. */
async function follow(id, say) {
  if (id === null) return say("nothing was to be done", "good", true);
  for (let look = 0; look < LOOKS_MAX; look += 1) {
    const told = await get(`/v1/bulk-actions/${encodeURIComponent(id)}`);
    const words = progressOf(told.request);
    if (told.request.pending === 0) {
      const why = told.refusals.length ? `: ${told.refusals[0].problem}` : "";
      return say(`${words}${why}`, told.request.refused + told.request.expired ? "bad" : "good", true);
    }
    say(words, "info", false);
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
  }
  say("still under way, see the page of bulk actions", "warn", true);
}

/** "12 of 24 done, 1 refused, 2 expired". */
export function progressOf({ subjects, done, refused, expired }) {
  const parts = [
    done === subjects ? `${done.toLocaleString("en")} done` : `${done.toLocaleString("en")} of ${subjects.toLocaleString("en")} done`,
    refused ? `${refused.toLocaleString("en")} refused` : null,
    expired ? `${expired.toLocaleString("en")} expired` : null,
  ];
  return parts.filter(Boolean).join(", ");
}

/** The link to the list of bulk actions. */
export const bulkLink = () =>
  has("GET", "/v1/bulk-actions") ? h("a", { href: link.bulk() }, "Bulk actions, with their progress") : null;
