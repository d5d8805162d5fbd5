// Checks of the visible page; each one returns a list of problems.
({
  overflow() {
    const { scrollWidth } = document.documentElement;
    return scrollWidth > innerWidth ? [`the page is ${scrollWidth} px wide on a screen of ${innerWidth} px`] : [];
  },

  // Elements of the content that scroll sideways, or whose content leaves them, in shadow trees too. Open parts count.
  sideways() {
    const inside = (root) => [...root.querySelectorAll("*")].flatMap((one) => [one, ...(one.shadowRoot ? inside(one.shadowRoot) : [])]);
    const main = document.querySelector("main");
    return [main, ...inside(main)]
      .filter((one) => one.clientWidth > 0 && !one.ownerSVGElement && !one.classList.contains("unseen") && one.scrollWidth > one.clientWidth)
      .map((one) => `${one.localName}.${one.getAttribute("class")}: ${one.scrollWidth} px in ${one.clientWidth} px: ${one.textContent.trim().slice(0, 40)}`);
  },

  // WCAG 2: lines and points of charts have a contrast of at least 3 to 1.
  lines() {
    const style = getComputedStyle(document.documentElement);
    const ratio = (name) => this.ratio(style.getPropertyValue(`--chart-${name}`), style.getPropertyValue("--panel"));
    return ["a", "b", "c", "m"].filter((name) => !(ratio(name) >= 3)).map((name) => `contrast ${ratio(name)} of --chart-${name}`);
  },

  headings() {
    const levels = [...document.querySelectorAll("main :is(h1, h2, h3, h4, h5, h6)")].map((one) =>
      Number(one.localName[1]),
    );
    const jumps = levels.filter((level, index) => level > (levels[index - 1] ?? 0) + 1);
    return [
      levels.filter((level) => level === 1).length !== 1 && `headings ${levels}: not one first one`,
      jumps.length && `headings ${levels} leave levels out`,
    ].filter(Boolean);
  },

  tables() {
    const bad = [...document.querySelectorAll("table")].filter(
      (table) =>
        !table.caption?.textContent ||
        [...table.querySelectorAll("th")].some((one) => !one.scope) ||
        !table.querySelector("tbody th"),
    );
    return bad.map((table) => `a table without caption or scopes: ${table.innerText.slice(0, 60)}`);
  },

  fields() {
    return [...document.querySelectorAll("input, select, textarea")]
      .filter((one) => !one.labels.length)
      .map((one) => `no label: ${one.outerHTML}`);
  },

  pictures() {
    const named = (svg) => svg.closest("[aria-hidden=true]") || svg.querySelector("title") || svg.ariaLabel;
    return [...document.querySelectorAll("svg")]
      .filter((svg) => !named(svg))
      .map((svg) => `no name: ${svg.outerHTML.slice(0, 80)}`);
  },

  // WCAG 2: the contrast between each text and its background is at least 4.5 to 1.
  contrast() {
    const wrong = new Set();
    for (const element of new Set(this.texts(document.body))) {
      const style = getComputedStyle(element);
      const ratio = this.ratio(element instanceof SVGElement ? style.fill : style.color, this.behind(element));
      this.least = Math.min(this.least ?? 99, ratio);
      const words = element.textContent.trim().slice(0, 40);
      if (ratio < 4.5) wrong.add(`contrast ${ratio.toFixed(2)} of ${element.localName}: ${words}`);
    }
    return [...wrong];
  },

  // WCAG 2: at least 3 to 1 for the frames of fields and buttons, and for the focus ring.
  frames() {
    const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
    const pairs = ["--line", "--focus"].flatMap((front) => ["--page", "--panel"].map((back) => [front, back]));
    const ratio = ([front, back]) => this.ratio(color(front), color(back));
    return pairs.filter((pair) => !(ratio(pair) >= 3)).map((pair) => `contrast ${ratio(pair)} of ${pair}`);
  },

  // Smallest contrast of a text so far.
  least: undefined,

  ratio(one, other) {
    const [front, back] = [one, other].map((color) => this.luminance(this.rgba(color)));
    return (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
  },

  luminance(color) {
    const linear = (one) => (one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4);
    const [r, g, b] = color.map((one) => linear(one / 255));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  },

  canvas: document.createElement("canvas").getContext("2d", { willReadFrequently: true }),

  rgba(color) {
    this.canvas.clearRect(0, 0, 1, 1);
    this.canvas.fillStyle = color;
    this.canvas.fillRect(0, 0, 1, 1);
    return [...this.canvas.getImageData(0, 0, 1, 1).data];
  },

  behind(element) {
    for (let one = element; one; one = one.parentElement ?? one.getRootNode().host) {
      const color = getComputedStyle(one).backgroundColor;
      if (this.rgba(color)[3] === 255) return color;
    }
    return "white";
  },

  // All visible elements that have text of their own.
  texts(root) {
    const silent = ["title", "desc", "style", "script", "metadata"];
    const found = [];
    const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const { textContent, parentElement } = walker.currentNode;
      const isShown = parentElement.getClientRects().length > 0 && !silent.includes(parentElement.localName);
      if (textContent.trim() && isShown) found.push(parentElement);
    }
    return found;
  },
});
