// Plots that the service draws: fetched with the token, and put into the page so that they take its colours.
//
// A plot lives in a shadow tree: its names and rules stay its own. Its rules become a style sheet object and its style
// attributes properties, since this page allows no inline styles; scripts, handlers and links elsewhere are left out.

import { text } from "./api.js";
import { h } from "./dom.js";

const FORBIDDEN = "script, foreignObject, iframe, object, embed, image, use:not([href^='#'])";
const FRAME = new CSSStyleSheet();
FRAME.replaceSync(`
  :host { display: block; overflow-x: auto }
  /* Its ground is the page's; on a phone it scrolls, for its words to stay legible. */
  .p-ground { fill: none }
  svg { display: block; inline-size: 100%; min-inline-size: 30rem; block-size: auto; max-block-size: 28rem; color: inherit }
`);

/** `<service-plot src="/v1/...plot.svg" version="...">`: drawn again when either changes. */
class ServicePlot extends HTMLElement {
  static observedAttributes = ["src", "version"];
  #shadow = this.attachShadow({ mode: "open" });
  #abort = null;
  #source = null;

  connectedCallback() {
    this.#draw();
  }

  disconnectedCallback() {
    this.#abort?.abort();
  }

  attributeChangedCallback() {
    if (this.isConnected) this.#draw();
  }

  async #draw() {
    this.#abort?.abort();
    this.#abort = new AbortController();
    try {
      const source = await text(this.getAttribute("src"), undefined, { signal: this.#abort.signal });
      if (source !== this.#source) this.#show(source);
      this.#source = source;
      this.dataset.state = "drawn";
    } catch (problem) {
      if (problem.name === "AbortError" || this.#source !== null) return;
      this.dataset.state = "failed";
      this.#shadow.textContent = `No picture: ${problem.message}`;
    }
  }

  #show(source) {
    const parsed = new DOMParser().parseFromString(withoutStyles(source), "image/svg+xml").documentElement;
    if (parsed.localName !== "svg") throw new Error("the service sent something that is no picture");
    const rules = [...parsed.querySelectorAll("[data-rules]")];
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(rules.map((one) => one.textContent).join("\n"));
    [...rules, ...parsed.querySelectorAll(FORBIDDEN)].forEach((element) => element.remove());
    const picture = document.importNode(parsed, true);
    [picture, ...picture.querySelectorAll("*")].forEach(clean);
    this.#shadow.adoptedStyleSheets = [sheet, FRAME];
    this.#shadow.replaceChildren(picture);
  }
}

/** Rules and style attributes under other names: even parsing them would be a breach of what this page allows. */
function withoutStyles(source) {
  return source
    .replace(/<style\b/g, "<metadata data-rules=''")
    .replace(/<\/style>/g, "</metadata>")
    .replace(/\sstyle=/g, " data-style=");
}

function clean(element) {
  for (const { name, value } of [...element.attributes]) {
    if (name === "data-style") {
      element.removeAttribute(name);
      element.style.cssText = value;
    } else if (name.startsWith("on") || (name.endsWith("href") && !value.startsWith("#")))
      element.removeAttribute(name);
  }
  if (element.localName === "svg") {
    element.setAttribute("role", "img");
    element.removeAttribute("width");
    element.removeAttribute("height");
  }
}

customElements.define("service-plot", ServicePlot);

/** A plot with its caption; it is drawn again when `version` changes. */
export function figure(key, src, version, title, about) {
  return h(
    "figure",
    { "data-key": `plot-${key}` },
    h("figcaption", {}, h("strong", {}, title), ". ", about),
    h("service-plot", { src, version, tabindex: "0", role: "group", "aria-label": title }),
  );
}
