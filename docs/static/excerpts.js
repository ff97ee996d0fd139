// Beside each hit of the search the words around the first place where its page has a word that was asked for.
"use strict";
(function () {
  // Letters before and after the word.
  const BEFORE = 80;
  const AFTER = 160;
  const texts = window.refdemTexts || {};
  const words = (new URLSearchParams(location.search).get("q") || "").toLowerCase().split(/\s+/).filter(Boolean);
  const root = new URL(document.documentElement.dataset.content_root || "./", location.href).href;

  // The name of the page that a link leads to.
  function pageOf(link) {
    return decodeURI(link.href.split(/[?#]/)[0].slice(root.length)).replace(/\.html$/, "");
  }

  // The search finds words of one stem, so endings are left away, up to three letters, until the text has the word.
  function placeOf(low, word) {
    const least = Math.max(4, word.length - 3);
    let part = word;
    while (part.length > least && !low.includes(part)) part = part.slice(0, -1);
    return [low.indexOf(part), part];
  }

  // Where a text first has one of the words, and that word; null if it has none.
  function found(text) {
    const low = text.toLowerCase();
    const places = words.map(function (word) { return placeOf(low, word); }).filter(function ([at]) { return at >= 0; });
    return places.length ? places.sort(function (one, other) { return one[0] - other[0]; })[0] : null;
  }

  function excerpt(text) {
    const said = document.createElement("p");
    said.className = "excerpt";
    const [at, word] = found(text) || [0, ""];
    const start = Math.max(0, text.lastIndexOf(" ", Math.max(0, at - BEFORE)));
    const end = Math.min(text.length, at + AFTER);
    const mark = document.createElement("mark");
    mark.textContent = text.slice(at, at + word.length);
    said.append(start > 0 ? "… " : "", text.slice(start, at).trimStart(), ...(word ? [mark] : []), text.slice(at + word.length, end), end < text.length ? " …" : "");
    return said;
  }

  function told() {
    document.querySelectorAll("#search-results li:not([data-told])").forEach(function (hit) {
      const link = hit.querySelector("a");
      hit.dataset.told = "yes";
      const text = link && texts[pageOf(link)];
      if (text) hit.append(excerpt(text));
    });
  }

  new MutationObserver(told).observe(document.getElementById("search-results"), { childList: true, subtree: true });
  told();
})();
