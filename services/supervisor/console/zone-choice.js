// The choice of the time zone in the footer.

import { h } from "./dom.js";
import { setZone, zoneChoice, zoneChoices } from "./zone.js";

/** Fills the field of the time zone. */
export function showZoneChoice(field) {
  const option = ([value, label]) => h("option", { value, selected: value === zoneChoice() }, label);
  field.replaceChildren(...zoneChoices().map(option));
  field.addEventListener("change", () => setZone(field.value));
}
