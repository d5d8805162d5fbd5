// Why a whisker learns, or does not: the use of its newest contacts.

import { get, ifServed } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { api, ROUTES } from "../places.js";
import { section, table } from "../table.js";
import { SEGMENTERS } from "../words.js";

/** Share of unused contacts above which they are explained. */
const EXPLAINED = 0.1;

/** Uses of the whisker's newest contacts; null for callers who may not read them. */
export function contactUsesOf(whisker) {
  return ifServed(`${ROUTES.whisker}/contact-uses`, () => get(`${api.whisker(whisker)}/contact-uses`), null);
}

/** What the robot says of finding contacts in samples of strain, with advice; null if it says nothing. */
export function segmenterFact(uses, segmenter) {
  if (!segmenter) return null;
  const remedy = uses?.segmenter?.state === segmenter ? uses.segmenter.remedy : null;
  return [markOf(SEGMENTERS, segmenter), remedy ? h("span", { class: "note" }, ` ${remedy}`) : null];
}

/** The section about unused contacts; null if nearly all are used. */
export function contactUses(uses) {
  if (!uses || uses.contacts - uses.contacts_used <= EXPLAINED * uses.contacts) return null;
  return section(
    "Contacts that are not used",
    h("p", {}, `Of the newest ${uses.contacts} contacts, ${uses.contacts_used} were used.`),
    table({
      caption: "Newest contacts by use, the most frequent first",
      rows: uses.items.filter((row) => row.remedy),
      key: (row) => `use-${row.used}`,
      empty: "",
      columns: [
        { name: "Reason", head: true, cell: (row) => row.meaning ?? row.used },
        { name: "Contacts", numeric: true, cell: (row) => String(row.contacts) },
        { name: "Newest", cell: (row) => time(row.newest_at) },
        { name: "Remedy", cell: (row) => h("span", { class: "note" }, row.remedy) },
      ],
    }),
  );
}
