// An address that leads nowhere.

import { h } from "../dom.js";
import { link } from "../places.js";

export default {
  load: async () => null,
  view: () => [
    h("h1", { tabindex: "-1" }, "There is no such page"),
    h("p", {}, "The address may be of an older version, or mistyped. ", h("a", { href: link.fleets() }, "All fleets")),
  ],
};
