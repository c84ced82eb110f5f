"use strict";
// Each figure and table can be saved: a figure as SVG, a table as CSV. Without scripts the page is
// the same, but for that.
(() => {
  const save = (text, type, name) => {
    const link = document.createElement("a");
    link.setAttribute("href", URL.createObjectURL(new Blob([text], { type })));
    link.download = name;
    link.click();
  };
  const name = (words, ending) => (words || "page").replace(/[^\w.]+/g, "_").replace(/^_|_$/g, "").slice(0, 60) + ending;
  const button = (place, label, action) => {
    const made = document.createElement("button");
    made.type = "button";
    made.className = "save";
    made.textContent = label;
    made.addEventListener("click", action);
    place.append(made);
  };
  for (const figure of document.querySelectorAll("figure")) {
    const picture = figure.querySelector(".wide svg");
    const caption = figure.querySelector("figcaption");
    if (!picture || !caption) continue;
    const title = caption.querySelector("strong");
    button(caption, "SVG", () => save(picture.outerHTML, "image/svg+xml", name(title && title.textContent, ".svg")));
  }
  const cell = (of) => `"${of.innerText.trim().replace(/\s*\n\s*/g, "; ").replaceAll('"', '""')}"`;
  for (const place of document.querySelectorAll("div.scroll")) {
    const heading = place.closest("section")?.querySelector("h2");
    const foot = document.createElement("div");
    foot.className = "foot";
    place.after(foot);
    button(foot, "CSV", () => {
      const rows = [...place.querySelectorAll("tr")].map((row) => [...row.children].map(cell).join(","));
      save(rows.join("\r\n") + "\r\n", "text/csv", name(heading && heading.textContent, ".csv"));
    });
  }
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
})();
