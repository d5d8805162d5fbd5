// Looks at the page as it is shown; each check gives what is wrong, as a list of sentences.
({
  overflow() {
    const { scrollWidth } = document.documentElement;
    return scrollWidth > innerWidth ? [`the page is ${scrollWidth} px wide on a screen of ${innerWidth} px`] : [];
  },

  headings() {
    const levels = [...document.querySelectorAll("main :is(h1, h2, h3, h4, h5, h6)")].map((one) => Number(one.localName[1]));
    const jumps = levels.filter((level, index) => level > (levels[index - 1] ?? 0) + 1);
    return [levels.filter((level) => level === 1).length !== 1 && `headings ${levels}: not one first one`, jumps.length && `headings ${levels} leave levels out`].filter(Boolean);
  },

  tables() {
    const bad = [...document.querySelectorAll("table")].filter(
      (table) => !table.caption?.textContent || [...table.querySelectorAll("th")].some((one) => !one.scope) || !table.querySelector("tbody th"),
    );
    return bad.map((table) => `a table without caption or scopes: ${table.innerText.slice(0, 60)}`);
  },

  fields() {
    return [...document.querySelectorAll("input, select, textarea")].filter((one) => !one.labels.length).map((one) => `no label: ${one.outerHTML}`);
  },

  pictures() {
    const named = (svg) => svg.closest("[aria-hidden=true]") || svg.querySelector("title") || svg.ariaLabel;
    const inPlots = [...document.querySelectorAll("service-plot")].flatMap((plot) => [...plot.shadowRoot.querySelectorAll("svg")]);
    return [...document.querySelectorAll("svg"), ...inPlots].filter((svg) => !named(svg)).map((svg) => `no name: ${svg.outerHTML.slice(0, 80)}`);
  },

  // WCAG 2: contrast of every text with what is behind it.
  contrast() {
    const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    const rgba = (color) => {
      canvas.clearRect(0, 0, 1, 1);
      canvas.fillStyle = color;
      canvas.fillRect(0, 0, 1, 1);
      return [...canvas.getImageData(0, 0, 1, 1).data];
    };
    const luminance = (color) => {
      const [r, g, b] = color.map((one) => one / 255).map((one) => (one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const behind = (element) => {
      for (let one = element; one; one = one.parentElement ?? one.getRootNode().host) {
        const color = rgba(getComputedStyle(one).backgroundColor);
        if (color[3] === 255) return color;
      }
      return [255, 255, 255, 255];
    };
    const texts = (root) => {
      const found = [];
      const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
      while (walker.nextNode()) {
        const { textContent, parentElement } = walker.currentNode;
        if (textContent.trim() && parentElement.getClientRects().length && !["title", "desc", "style", "script", "metadata"].includes(parentElement.localName)) found.push(parentElement);
      }
      return found;
    };
    const all = [...texts(document.body), ...[...document.querySelectorAll("service-plot")].flatMap((plot) => texts(plot.shadowRoot))];
    const wrong = new Set();
    for (const element of new Set(all)) {
      const style = getComputedStyle(element);
      const ink = element instanceof SVGElement ? style.fill : style.color;
      const [front, back] = [luminance(rgba(ink)), luminance(behind(element))];
      const ratio = (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
      this.least = Math.min(this.least ?? 99, ratio);
      if (ratio < 4.5) wrong.add(`contrast ${ratio.toFixed(2)} of ${element.localName}.${element.getAttribute("class")}: ${element.textContent.trim().slice(0, 40)}`);
    }
    return [...wrong];
  },

  // The least contrast that was found.
  least: undefined,
})
