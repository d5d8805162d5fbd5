// The board: one tile for each robot, in groups by fleet or label, with a letter and a colour for its worst state.

import { changed, stateOf } from "../address.js";
import { get, has } from "../api.js";
import { choiceField, searchField } from "../browse.js";
import { h, s } from "../dom.js";
import { count } from "../format.js";
import { mark } from "../marks.js";
import { link } from "../places.js";
import { ROBOT_STATES } from "../words.js";
import { aside } from "./worst.js";

const BOARD = "/v1/board";

/** Up to so many robots a tile has the robot's name, or room for a larger letter. */
const NAMED_MAX = 60;
const LARGE_MAX = 400;
/** Groups of more robots take the whole width. */
const WIDE_FROM = 60;

/** The states that somebody must look at. */
const TROUBLES = ["UNCOMPENSATED", "FAULTY", "CONNECTION_BROKEN", "SILENT", "ALARM"];

const collator = new Intl.Collator("en", { numeric: true });

/** Reads the board that an address asks for; null if the service has none. */
export async function boardOf({ state, by, label, q }, fleet) {
  return has("GET", BOARD) ? get(BOARD, { fleet, state, by, label, q }) : null;
}

/** Numbers of robots by state, over all groups. */
export function totals(board) {
  const sums = {};
  for (const { states } of board.groups)
    for (const [state, robots] of Object.entries(states)) sums[state] = (sums[state] ?? 0) + robots;
  return sums;
}

const sumOf = (states, names) => names.reduce((sum, name) => sum + (states[name] ?? 0), 0);

/** How the robots are, in one sentence. `isPart` if a search or a label has chosen some of them. */
export function verdict(board, isPart = false) {
  const states = totals(board);
  const [all, troubled] = [sumOf(states, Object.keys(states)), sumOf(states, TROUBLES)];
  if (!all) return isPart ? "No robots match." : "No robots yet.";
  const robots = isPart ? `${count(all, "robot")} that ${all === 1 ? "matches" : "match"}` : count(all, "robot");
  if (troubled) return `${troubled.toLocaleString("en")} of ${robots} ${troubled === 1 ? "needs" : "need"} attention.`;
  if (isPart) return `None of ${robots} needs attention.`;
  if (states.HEALTHY === all) return `Nothing needs attention: ${robots}, all healthy.`;
  return `No robot needs attention: ${robots}.`;
}

/** The board; `more(group)` are marks of a fleet, and `fleet` is set if the board is of one fleet. */
export function board(told, { fleet, more = () => null } = {}) {
  if (!told) return null;
  const state = stateOf(location.hash);
  return h(
    "div",
    { class: `overview ${fleet && told.robots.length <= NAMED_MAX && !told.folded ? "few" : ""}` },
    h(
      "div",
      { class: "board" },
      filters(told, state),
      told.folded ? foldedGroups(told, state) : tileGroups(told, state, { fleet, more }),
    ),
    aside(told, fleet, !fleet && Boolean(state.label || state.q)),
  );
}

/** Counts by state, each of which filters the board. */
function filters(told, state) {
  const states = totals(told);
  const chip = (name, words, many, face) =>
    h(
      "li",
      {},
      h(
        "a",
        {
          class: "chip",
          href: changed({ state: name }),
          "aria-current": (state.state ?? null) === name ? "true" : null,
        },
        face,
        h("strong", {}, many.toLocaleString("en")),
        h("span", {}, ` ${words}`),
      ),
    );
  const known = Object.entries(ROBOT_STATES).filter(([name]) => states[name] || state.state === name);
  const all = sumOf(states, Object.keys(states));
  return h(
    "nav",
    { "aria-label": "Robots by state" },
    h(
      "ul",
      { class: "chips" },
      chip(null, all === 1 ? "robot" : "robots", all, null),
      known.map(([name, [words]]) => chip(name, words, states[name] ?? 0, face(name))),
    ),
  );
}

const face = (name) =>
  h("span", { class: `tile ${toneOf(name)}`, "aria-hidden": "true" }, ROBOT_STATES[name]?.[2] ?? "?");
const toneOf = (name) => ROBOT_STATES[name]?.[1] ?? "off";

/** The search of robots and the choice of groups; null without a board. */
export function boardTools(told) {
  if (!told) return null;
  const state = stateOf(location.hash);
  const by = told.label_keys.map((key) => [key, `by ${key}`]);
  return h(
    "form",
    { class: "tools", role: "search", "aria-label": "Find robots", onsubmit: (event) => event.preventDefault() },
    searchField(state, "Search robots", true),
    by.length ? choiceField({ name: "by", label: "Groups", options: by, empty: "by fleet", isBare: true }, state) : null,
    state.q || state.label || state.state
      ? h("a", { href: changed({ q: null, label: null, state: null }) }, "Show all")
      : null,
  );
}

/** Name of a group, its address, and its robots in words. */
const nameOf = ({ group }, state) => group ?? `no label ${state.by}`;
const addressOf = ({ group }, state) => {
  if (group === null) return null;
  return state.by ? changed({ label: `${state.by}=${group}` }) : link.fleet(group);
};

function trouble({ states, robots }) {
  const troubled = sumOf(states, TROUBLES);
  const need = `, ${troubled.toLocaleString("en")} ${troubled === 1 ? "needs" : "need"} attention`;
  return `${count(robots, "robot")}${troubled ? need : ""}`;
}

function heading(group, state, fleet, ...more) {
  const address = addressOf(group, state);
  const name = nameOf(group, state);
  if (fleet && !state.by) return h("h2", {}, "Robots ", h("small", {}, trouble(group)));
  return h("h2", {}, address ? h("a", { href: address }, name) : name, " ", h("small", {}, trouble(group)), more);
}

function tileGroups(told, state, { fleet, more }) {
  const robots = Map.groupBy(told.robots, (robot) => robot.group);
  const size = told.robots.length <= NAMED_MAX ? "named" : told.robots.length <= LARGE_MAX ? "large" : "small";
  const shown = told.groups.map((group, index) => [group, robots.get(index) ?? []]).filter(([, some]) => some.length);
  if (!shown.length) {
    const words = told.groups.length ? "No robot is in this state." : "No robots match.";
    return h("p", { class: "empty" }, state.state || state.q || state.label ? words : "No robots yet.");
  }
  let isFirst = true;
  const tile = (robot) => {
    const [words, tone, letter] = ROBOT_STATES[robot.state] ?? [robot.state, "off", "?"];
    const reason = robot.whiskers ? `${words}: ${count(robot.whiskers, "whisker")}` : words;
    const alarms = robot.alarms ? `, ${count(robot.alarms, "alarm")}` : "";
    const about = `${fleet ? "" : ` of ${robot.fleet}`}: ${reason}${alarms}`;
    const isNamed = size === "named";
    const title = `${robot.robot}${about}`;
    const tab = isFirst ? 0 : -1;
    isFirst = false;
    return h(
      "li",
      { "data-key": `tile-${robot.fleet}-${robot.robot}` },
      h(
        "a",
        { class: `tile ${tone}`, href: link.robot(robot), title, "aria-label": isNamed ? null : title, tabindex: tab },
        h("span", { class: "letter", "aria-hidden": "true" }, letter),
        isNamed ? [h("span", { class: "who" }, robot.robot), h("span", { class: "unseen" }, about)] : null,
      ),
    );
  };
  const group = ([about, some]) =>
    h(
      "li",
      { class: some.length > WIDE_FROM || shown.length === 1 ? "wide" : null, "data-key": `group-${about.group}` },
      heading(about, state, fleet, more(about.group)),
      h("ul", { class: "tiles" }, some.sort((one, other) => collator.compare(one.robot, other.robot)).map(tile)),
    );
  return [
    h("p", { class: "unseen", id: "board-keys" }, "Arrow keys move from robot to robot."),
    h(
      "ul",
      { class: `tile-groups ${size}`, "aria-label": "Robots", "aria-describedby": "board-keys", onkeydown: move },
      shown.sort(([one], [other]) => collator.compare(one.group ?? "\uffff", other.group ?? "\uffff")).map(group),
    ),
  ];
}

/** Moves the focus between the tiles: to the neighbour, to the next line, or to the ends. */
function move(event) {
  const tiles = [...event.currentTarget.querySelectorAll("a.tile")];
  const at = tiles.indexOf(document.activeElement);
  if (at < 0 || event.ctrlKey || event.altKey || event.metaKey) return;
  const nextLine = (step) => {
    const here = tiles[at].getBoundingClientRect();
    for (let index = at + step, best = null; ; index += step) {
      const there = tiles[index]?.getBoundingClientRect();
      const isOther = there && Math.abs(there.top - here.top) > 4;
      if (best && (!there || Math.abs(there.top - best.top) > 4)) return best.index;
      if (!there) return at;
      if (isOther && (!best || Math.abs(there.left - here.left) < best.far))
        best = { index, top: there.top, far: Math.abs(there.left - here.left) };
    }
  };
  const targets = {
    ArrowRight: () => at + 1,
    ArrowLeft: () => at - 1,
    ArrowDown: () => nextLine(1),
    ArrowUp: () => nextLine(-1),
    Home: () => 0,
    End: () => tiles.length - 1,
  };
  const next = targets[event.key] && tiles[targets[event.key]()];
  if (!next) return;
  event.preventDefault();
  next.focus();
}

/** Too many robots for tiles: a bar of states for each group, those with most trouble first. */
function foldedGroups(told, state) {
  const names = Object.keys(ROBOT_STATES);
  const chosen = state.state ? [state.state] : TROUBLES;
  const groups = told.groups.filter((group) => !state.state || group.states[state.state]);
  const bad = (group) => sumOf(group.states, chosen);
  groups.sort((one, other) => bad(other) - bad(one) || collator.compare(one.group ?? "\uffff", other.group ?? "\uffff"));
  const bar = ({ states, robots, group }) => {
    let x = 0;
    const part = (name) => {
      const width = ((states[name] ?? 0) / robots) * 100;
      const drawn = s("rect", { x, y: 0, width, height: 8, class: toneOf(name) });
      x += width;
      return width ? drawn : null;
    };
    const said = names.filter((name) => states[name]).map((name) => `${states[name]} ${ROBOT_STATES[name][0]}`);
    return s(
      "svg",
      {
        viewBox: "0 0 100 8",
        preserveAspectRatio: "none",
        class: "states",
        role: "img",
        "aria-label": `${nameOf({ group }, state)}: ${said.join(", ")}`,
      },
      names.map(part),
    );
  };
  const item = (group) =>
    h(
      "li",
      { "data-key": `group-${group.group}` },
      heading(group, state, null),
      bar(group),
      h(
        "p",
        { class: "marks" },
        names
          .filter((name) => group.states[name] && name !== "HEALTHY")
          .slice(0, 4)
          .map((name) => mark(`${group.states[name].toLocaleString("en")} ${ROBOT_STATES[name][0]}`, toneOf(name), null)),
      ),
    );
  return [
    h("p", { class: "hint" }, "These are too many robots for tiles. Open a group, choose a state, or search."),
    h("ul", { class: "folded" }, groups.map(item)),
  ];
}

