// The page for an unknown address.

import { h } from "../dom.js";
import { link } from "../places.js";

export default {
  load: async () => null,
  view: () => [
    h("h1", { tabindex: "-1" }, "Page not found"),
    h("p", {}, "The address may be outdated or mistyped. ", h("a", { href: link.fleets() }, "All fleets")),
  ],
};
