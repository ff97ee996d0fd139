// Draws the charts of a page, loads its parts and replays, hides and sorts rows of its tables, each when a reader comes to it; no request leaves the disk.
"use strict";
(function () {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const assets = document.currentScript.src.replace(/[^/]*$/, "");
  // How far below the screen [px] a chart or a part is when it is made ready.
  const AHEAD = "800px";
  // Widths [px]: where small pictures are fitted, and what their axes, gaps and the menu take.
  const NARROW = 700;
  const BESIDE = 110;
  const scripts = new Map();

  // The promise that a script of assets/ has run; each runs once.
  function script(name) {
    if (!scripts.has(name)) {
      scripts.set(name, new Promise(function (done, failed) {
        const element = document.createElement("script");
        element.src = assets + encodeURIComponent(name);
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
      text: { color: ink },
      header: { labelColor: ink, titleColor: ink },
      view: { stroke: line },
      axis: { gridColor: line, domainColor: line, tickColor: line, labelColor: ink, titleColor: ink, titleFontWeight: "normal" },
      legend: { labelColor: ink, titleColor: ink, titleFontWeight: "normal", labelLimit: 260 },
    };
  }

  // On a narrow screen two small pictures stand beside each other, and are as wide as there is room;
  // heat maps stand below each other.
  function fitted(spec, room) {
    if (spec.concat && room < NARROW) spec.columns = 1;
    if (!spec.facet || room >= NARROW) return spec;
    spec.columns = 2;
    spec.spec.width = Math.max(100, Math.floor((room - BESIDE) / 2));
    spec.facet.header.labelLimit = spec.spec.width;
    return spec;
  }

  function embed(place) {
    const spec = fitted(JSON.parse(document.getElementById(place.dataset.spec).textContent), place.closest(".frame").clientWidth);
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

  // A table that goes on to the right of its frame fades there, and says how to see the rest.
  const wide = new ResizeObserver(function (entries) { for (const entry of entries) hint(entry.target.closest(".scroll")); });

  function hint(frame) {
    const left = frame.scrollWidth - frame.clientWidth - frame.scrollLeft;
    frame.classList.toggle("more", left > 2);
    const told = frame.previousElementSibling;
    if (frame.scrollWidth - frame.clientWidth <= 2) {
      if (told && told.matches(".sideways")) told.remove();
      return;
    }
    if (told && told.matches(".sideways")) return;
    const words = document.createElement("p");
    words.className = "sideways quiet";
    words.textContent = "This table goes on to the right: scroll it sideways →";
    frame.before(words);
  }

  function watch(root) {
    root.querySelectorAll(".scroll").forEach(function (frame) {
      wide.observe(frame);
      if (frame.firstElementChild) wide.observe(frame.firstElementChild);
      frame.addEventListener("scroll", function () { hint(frame); }, { passive: true });
    });
    root.querySelectorAll(".plot[data-spec], .part[data-part]").forEach(function (place) { coming.observe(place); });
    root.querySelectorAll("table[data-sorts]").forEach(sortable);
  }

  // Every header becomes a button, or gets one if it has a link, as a button must not contain links.
  function sortable(table) {
    for (const header of table.tHead.rows[0].cells) {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      if (header.querySelector("a")) {
        button.setAttribute("aria-label", "Sort by " + header.textContent.trim());
        header.append(" ", button);
      } else {
        button.append(...header.childNodes);
        header.append(button);
      }
    }
    // The order in which the rows came, to which the third click returns.
    Array.from(table.tBodies).forEach(function (body, place) {
      body.dataset.place = place;
      Array.from(body.rows).forEach(function (row, index) { row.dataset.place = index; });
    });
  }

  // What a cell is sorted by: null if it says that there is nothing, a number if it starts with one, else its words.
  function sortKey(row, column) {
    const cell = row && row.cells[column];
    const text = cell ? cell.textContent.trim().toLowerCase() : "";
    if (/^(|none|[·–—-])$/.test(text)) return null;
    const number = /^[≥≤~<>]?\s*([-+−]?\d+(\.\d+)?(e[+-]?\d+)?)(?![\w.])/.exec(text);
    return number ? Number(number[1].replace("−", "-")) : text;
  }

  // Numbers before words, each in its order; what is absent comes last in either direction.
  function compared(one, other, sense) {
    if (one === null || other === null) return (one === null) - (other === null);
    if (typeof one !== typeof other) return typeof one === "number" ? -sense : sense;
    if (typeof one === "number") return sense * (one - other);
    return sense * one.localeCompare(other, "en", { numeric: true });
  }

  // The rows of each group in their order, and the groups by the first row of each.
  function sort(header) {
    const table = header.closest("table");
    const column = header.cellIndex;
    const next = { none: "ascending", ascending: "descending", descending: "none" };
    const order = next[header.getAttribute("aria-sort") || "none"];
    for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
    if (order !== "none") header.setAttribute("aria-sort", order);
    const sense = order === "descending" ? -1 : 1;
    // Rows or groups in their order, `shown` tells the row that stands for each.
    const ordered = function (items, shown) {
      const keys = new Map(items.map(function (item) { return [item, order === "none" ? null : sortKey(shown(item), column)]; }));
      return items.sort(function (one, other) {
        return compared(keys.get(one), keys.get(other), sense) || Number(one.dataset.place) - Number(other.dataset.place);
      });
    };
    for (const body of table.tBodies) {
      const rows = Array.from(body.rows).filter(function (row) { return !row.classList.contains("group"); });
      body.append(...ordered(rows, function (row) { return row; }));
    }
    const first = function (body) {
      return Array.from(body.rows).find(function (row) { return !row.classList.contains("group") && row.checkVisibility(); });
    };
    const bodies = ordered(Array.from(table.tBodies), first);
    table.append(...bodies);
  }

  // What a row is found by: its first cells, as many as its table says.
  function named(row) {
    const count = Number(row.closest("table").dataset.named);
    const texts = Array.from(row.cells).slice(0, count).map(function (cell) { return cell.textContent; });
    return texts.concat(row.dataset.words || "").join(" ").toLowerCase();
  }

  // The rows that have every word stay; of a group with its name in its first row, all rows where the name has them.
  function filter(field) {
    const table = document.getElementById(field.dataset.filter);
    // A plural finds the singular, as on the command line.
    const words = field.value.toLowerCase().split(/\s+/).map(function (word) { return word.replace(/s$/, ""); }).filter(Boolean);
    const has = function (text) { return words.every(function (word) { return text.includes(word); }); };
    let left = 0;
    for (const body of table.tBodies) {
      const group = body.querySelector("tr.group");
      const name = group ? named(group) + " " : "";
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

  // A replay arrives when its reader opens it: the script that plays it first. The event does not rise, so it is caught on its way down.
  document.addEventListener("toggle", function (event) {
    const place = event.target;
    if (!place.matches("details[data-replay]") || !place.open || place.dataset.asked) return;
    place.dataset.asked = "yes";
    script("replay.js").then(function () { return script("replay-" + place.dataset.replay + ".js"); }).catch(function (error) {
      place.querySelector(".waiting").textContent = "The replay could not be loaded: " + error.message;
      console.error(error);
    });
  }, true);
  document.addEventListener("click", function (event) {
    const button = event.target.closest("button.sort");
    if (button) sort(button.closest("th"));
  });
  document.addEventListener("input", function (event) {
    if (event.target.matches("[data-filter]")) filter(event.target);
  });
  dark.addEventListener("change", function () {
    document.querySelectorAll(".plot[data-drawn]").forEach(draw);
  });
  watch(document);
})();
