// Draws the charts of a page, loads its parts and hides rows of its tables, each when a reader comes to it; no request leaves the disk.
"use strict";
(function () {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const assets = document.currentScript.src.replace(/[^/]*$/, "");
  // How far below the screen [px] a chart or a part is when it is made ready.
  const AHEAD = "800px";
  const scripts = new Map();

  // The promise that a script of assets/ has run; each runs once.
  function script(name) {
    if (!scripts.has(name)) {
      scripts.set(name, new Promise(function (done, failed) {
        const element = document.createElement("script");
        element.src = assets + name;
        element.onload = done;
        element.onerror = function () { failed(new Error("assets/" + name + " is missing")); };
        document.head.append(element);
      }));
    }
    return scripts.get(name);
  }

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

  function embed(place) {
    const spec = JSON.parse(document.getElementById(place.dataset.spec).textContent);
    const options = { mode: "vega-lite", renderer: "svg", config: configuration(), actions: { export: true, source: false, compiled: false, editor: false } };
    return window.vegaEmbed(place, spec, options);
  }

  function draw(place) {
    return script("vega.js").then(function () { return embed(place); }).then(
      function () {
        // The button of the menu has no text, and a title that nobody hears.
        place.querySelectorAll("summary").forEach(function (button) { button.setAttribute("aria-label", "Save this chart"); });
        place.dataset.drawn = "yes";
      },
      function (error) { place.textContent = "This chart could not be drawn: " + error; console.error(error); }
    );
  }

  // A part arrives as a call of this function; templates have escaped what is in it.
  window.refdemPart = function (name, html) {
    const place = document.querySelector('[data-part="' + name + '"]');
    place.innerHTML = html;
    place.dataset.loaded = "yes";
    watch(place);
  };

  function load(place) {
    return script("index-" + place.dataset.part + ".js").catch(function (error) {
      place.textContent = "This part of the page could not be loaded: " + error;
      console.error(error);
    });
  }

  const coming = new IntersectionObserver(function (entries) {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      coming.unobserve(entry.target);
      if (entry.target.dataset.spec) draw(entry.target);
      else load(entry.target);
    }
  }, { rootMargin: AHEAD + " 0px" });

  function watch(root) {
    root.querySelectorAll(".plot[data-spec], .part[data-part]").forEach(function (place) { coming.observe(place); });
  }

  // What a row is found by: its first cells, as many as its table says.
  function named(row) {
    const count = Number(row.closest("table").dataset.named);
    return Array.from(row.cells).slice(0, count).map(function (cell) { return cell.textContent; }).join(" ").toLowerCase();
  }

  // The rows that have every word stay; of a group with its name in its first row, all rows where the name has them.
  function filter(field) {
    const table = document.getElementById(field.dataset.filter);
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    const has = function (text) { return words.every(function (word) { return text.includes(word); }); };
    let left = 0;
    for (const body of table.tBodies) {
      const group = body.querySelector("tr.group");
      const name = group ? group.textContent.toLowerCase() + " " : "";
      let own = 0;
      for (const row of body.rows) {
        if (row === group) continue;
        row.hidden = !has(name + named(row));
        // A row of a single quantity counts with the row of its run.
        if (!row.hidden && !row.classList.contains("single")) own += 1;
      }
      body.hidden = own === 0;
      left += own;
    }
    const told = document.querySelector('[data-left="' + field.dataset.filter + '"]');
    if (words.length === 0) told.textContent = "";
    else told.textContent = left === 1 ? "1 row" : left + " rows";
  }

  document.addEventListener("input", function (event) {
    if (event.target.matches("[data-filter]")) filter(event.target);
  });
  dark.addEventListener("change", function () {
    document.querySelectorAll(".plot[data-drawn]").forEach(draw);
  });
  watch(document);
})();
