// Draws the figures of a page in its colours, anew whenever these change.
(() => {
  const colour = (name) => getComputedStyle(document.body).getPropertyValue(name).trim();
  const look = (layout) => {
    const line = colour("--color-background-border");
    const themed = { ...layout, template: undefined, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" };
    themed.font = { ...layout.font, color: colour("--color-foreground-primary") };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis/.test(key)) themed[key] = { automargin: true, ...layout[key], gridcolor: line, linecolor: line };
    }
    return themed;
  };
  const draw = () => {
    for (const place of document.querySelectorAll(".drawn")) {
      place.content ??= JSON.parse(place.querySelector("script").textContent);
      Plotly.react(place, place.content.data, look(place.content.layout), { displayModeBar: false, responsive: true });
    }
  };
  addEventListener("load", () => {
    if (!document.querySelector(".drawn")) return;
    draw();
    new MutationObserver(draw).observe(document.body, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  });
})();
