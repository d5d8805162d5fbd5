// Plots drawn by the service: fetched with the token, and embedded so that they use the page's colours.
//
// A plot lives in a shadow tree, so that its names and rules do not leak. Its rules become a style sheet object and its
// style attributes become properties, because this page allows no inline styles. Scripts, handlers and external links
// are removed.

import { text } from "./api.js";
import { h } from "./dom.js";

const FORBIDDEN = "script, foreignObject, iframe, object, embed, image, use:not([href^='#'])";
const FRAME = new CSSStyleSheet();
FRAME.replaceSync(`
  :host { display: block; overflow-x: auto }
  /* The background is the page's. On a phone the plot scrolls, so that its text stays legible. */
  .p-ground { fill: none }
  svg { display: block; inline-size: 100%; min-inline-size: 30rem; block-size: auto; max-block-size: 28rem; color: inherit }
`);

/** `<service-plot src="/v1/...plot.svg" version="...">`: redrawn when either changes. */
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
      this.#shadow.textContent = `No plot: ${problem.message}`;
    }
  }

  #show(source) {
    const parsed = new DOMParser().parseFromString(withoutStyles(source), "image/svg+xml").documentElement;
    if (parsed.localName !== "svg") throw new Error("the service did not send a plot");
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

/** Renames rules and style attributes: the page's policy forbids even parsing them. */
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

/** A plot with its caption; redrawn when `version` changes. */
export function figure(key, src, version, title, about) {
  return h(
    "figure",
    { "data-key": `plot-${key}` },
    h("figcaption", {}, h("strong", {}, title), ". ", about),
    h("service-plot", { src, version, tabindex: "0", role: "group", "aria-label": title }),
  );
}
