// Follows a setpoint until the robot has applied or rejected it: an executed action has only sent it.

import { get, list } from "./api.js";
import { mpa } from "./format.js";
import { say, SETPOINT_ERRORS, SETPOINT_STATES } from "./words.js";

/** A state is asked for at this interval. */
const PAUSE_MS = 1_000;
/** Most requests for the states of one setpoint: 10 minutes. */
const LOOKS_MAX = 600;
/** Newest setpoints of the whisker among which the one of an action is looked for. */
const NEWEST = 10;

const UNDER_WAY = ["PENDING", "RECEIVED", "APPLYING"];

/** A later setpoint of a robot has a higher epoch, or a higher version of the same epoch. */
const isLater = (one, other) => one.epoch - other.epoch || one.version - other.version;

/** The newest setpoints of a whisker, the last one first; an empty list if the whisker never had one. */
async function newest({ fleet, robot, array, whisker }) {
  const rows = await list("/v1/setpoints", { fleet, robot, array, whisker, limit: NEWEST });
  return rows.sort((one, other) => isLater(other, one));
}

/**
 * Prepares to follow the setpoint that an action on a whisker leads to. Call it before the action; call its result
 * after the execution with `tell(words, tone, isFinal)`, which is called at each change of the state.
 */
export async function follower(whisker) {
  const before = (await newest(whisker))[0];
  return async (tell) => {
    // The setpoint is committed with the action. An equal one may have been under way already.
    const isOwn = (row) => !before || isLater(row, before) > 0 || UNDER_WAY.includes(row.state);
    const own = (await newest(whisker)).find(isOwn);
    if (!own) return tell("no setpoint was necessary, the whisker holds the pressure already", "good", true);
    let told = null;
    for (let look = 0; look < LOOKS_MAX; look += 1) {
      const now = await get(`/v1/setpoints/${encodeURIComponent(own.command_id)}`);
      if (now.state !== told) tell(...words(now));
      told = now.state;
      if (!UNDER_WAY.includes(now.state)) return;
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
    tell("the robot has not answered yet; the whisker's page shows its setpoints", "warn", true);
  };
}

function words({ state, pressure_mpa: asked, reached_mpa: reached, error }) {
  if (state === "PENDING") return [`${mpa(asked)} sent, waiting for the robot`, "info", false];
  if (UNDER_WAY.includes(state)) return [`${mpa(asked)}: ${say(SETPOINT_STATES, state)}`, "info", false];
  if (state === "APPLIED") return [`the robot applied ${mpa(reached ?? asked)}`, "good", true];
  if (error === "IN_TASK") return [`${mpa(asked)} ${say(SETPOINT_ERRORS, error)}`, "warn", true];
  const why = error ? `: ${say(SETPOINT_ERRORS, error)}` : "";
  return [`${mpa(asked)} not applied, ${say(SETPOINT_STATES, state)}${why}`, "bad", true];
}
