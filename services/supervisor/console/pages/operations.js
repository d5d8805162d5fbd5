// The REST interface: its operations by subject, from the service's own OpenAPI document.

import { operations } from "../api.js";
import { h } from "../dom.js";
import { link } from "../places.js";
import { section, table } from "../table.js";

export default {
  load: async () => operations(),

  view(all) {
    const subjects = [...new Set(all.map((one) => one.subject))];
    return [
      h("h1", { tabindex: "-1" }, "API"),
      h(
        "p",
        { class: "summary" },
        `${all.length} operations. Programs read them from the `,
        h("a", { href: "openapi.json" }, "OpenAPI document"),
        ". Each change needs the role that is named beside it; reading needs a viewer.",
      ),
      subjects.map((subject) => part(subject, all)),
    ];
  },
};

function part(subject, all) {
  const rows = all.filter((one) => one.subject === subject);
  const title = subject[0].toUpperCase() + subject.slice(1);
  return section(title, table({ caption: `Operations: ${subject}`, rows, columns: COLUMNS, key: (row) => `operation-${row.id}` }));
}

const COLUMNS = [
  {
    name: "Operation",
    head: true,
    cell: (row) => h("a", { class: "operation", href: link.operation(row.id) }, h("b", {}, row.method), " ", row.route),
  },
  { name: "Purpose", cell: (row) => row.summary },
  { name: "Role", cell: (row) => row.role.toLowerCase() },
];
