// Draws every chart of a page from the specification beside it, in the colours of the page; no request leaves the disk.
"use strict";
(function () {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  function configuration() {
    const ink = dark.matches ? "#d5dae0" : "#30363d";
    const line = dark.matches ? "#3a424c" : "#dfe3e8";
    return {
      background: "transparent",
      font: "system-ui, sans-serif",
      title: { color: ink },
      header: { labelColor: ink, titleColor: ink },
      view: { stroke: line },
      axis: { gridColor: line, domainColor: line, tickColor: line, labelColor: ink, titleColor: ink, titleFontWeight: "normal" },
      legend: { labelColor: ink, titleColor: ink, titleFontWeight: "normal", labelLimit: 260 },
    };
  }

  function draw(place) {
    const spec = JSON.parse(document.getElementById(place.dataset.spec).textContent);
    const options = { mode: "vega-lite", renderer: "svg", config: configuration(), actions: { export: true, source: false, compiled: false, editor: false } };
    return window.vegaEmbed(place, spec, options).then(
      function () { place.dataset.drawn = "yes"; },
      function (error) { place.textContent = "This chart could not be drawn: " + error; console.error(error); }
    );
  }

  function drawAll() {
    document.querySelectorAll(".plot[data-spec]").forEach(draw);
  }

  if (window.vegaEmbed) {
    drawAll();
    dark.addEventListener("change", drawAll);
  }
})();
