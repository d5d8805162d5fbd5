// The shards of a divided fleet with their owners.

import { get, has } from "../api.js";
import { count, orNone, time } from "../format.js";
import { api, ROUTES } from "../places.js";
import { section, table } from "../table.js";

const COLUMNS = [
  { name: "Shard", head: true, numeric: true, cell: (row) => String(row.shard) },
  { name: "Supervisor", cell: (row) => row.holder ?? "no supervisor" },
  { name: "Epoch", numeric: true, cell: (row) => String(row.epoch) },
  { name: "Owned since", cell: (row) => (row.began_at ? time(row.began_at) : orNone(null)) },
  { name: "Robots", numeric: true, cell: (row) => String(row.robots) },
];

/** The shards of a fleet; none if it is not divided. */
export async function shardsOf({ fleet, shards: number }) {
  if (number < 2 || !has("GET", ROUTES.shards)) return [];
  return (await get(api.shards(fleet))).items;
}

/** The table of the shards. */
export function shards(rows) {
  if (!rows.length) return null;
  const wanted = rows[0].shards_wanted;
  const change = wanted === rows.length ? "" : `, which become ${wanted}`;
  const caption = `${count(rows.length, "shard")}${change}`;
  return section(
    "Shards",
    table({ caption, columns: COLUMNS, rows, key: (row) => `shard-${row.shard}`, empty: "No shard is known." }),
  );
}
