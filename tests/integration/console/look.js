// What a part of the page looks like, without its data: its texts with digits as #, and its styles. Positions and sizes
// depend on the fonts of the machine and are left out.
(roots) => {
  const STYLES = [
    "color", "background-color", "font-size", "font-weight", "text-align", "display", "flex-direction",
    "padding-top", "padding-left", "border-top-width", "border-top-color", "border-top-left-radius", "stroke", "fill",
  ];
  const masked = (text) =>
    text
      .replace(/just now|in \d+ \w+|\d+ \w+ ago/g, "(age)")
      .replace(/\d+/g, "#")
      .replace(/\s+/g, " ")
      .trim();
  const own = (node) => [...node.childNodes].filter((one) => one.nodeType === Node.TEXT_NODE).map((one) => one.data);
  const lines = new Set();
  for (const root of roots.flatMap((selector) => [...document.querySelectorAll(selector)])) {
    for (const node of [root, ...root.querySelectorAll("*")]) {
      if (!node.getClientRects().length) continue;
      const style = getComputedStyle(node);
      const styles = STYLES.map((name) => style.getPropertyValue(name)).join("; ");
      const name = `${node.localName}${node.getAttribute("class") ? `.${node.getAttribute("class")}` : ""}`;
      lines.add(`${name} | ${masked(own(node).join(" "))} | ${styles}`);
    }
  }
  return [...lines].sort();
}
