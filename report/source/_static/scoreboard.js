/* Filters of the scoreboard. State stands in the address: #kind=claim&verdict=differs
   Each choice has its field in the data of a row. */
(function () {
  "use strict";
  const form = document.getElementById("rx-filter");
  const shown = document.getElementById("rx-shown");
  const board = document.getElementById("rx-board");
  if (!form || !shown || !board) return;

  const rows = Array.from(board.querySelectorAll("tr[data-verdict]"), (element) => ({
    element,
    verdict: element.dataset.verdict,
    text: element.textContent.toLowerCase(),
  }));
  const folds = Array.from(board.querySelectorAll("details.rx-pending"));
  const names = ["chapter", "kind", "verdict", "readings", "test", "q"];
  const chosen = names.filter((name) => name !== "q");
  const order = Array.from(form.elements.verdict.options, (option) => option.value);

  function state() {
    const found = {};
    for (const name of names) {
      const value = form.elements[name].value.trim();
      if (value) found[name] = value;
    }
    return found;
  }

  function fits(row, wanted, words) {
    return (
      chosen.every((n) => !wanted[n] || row.element.dataset[n] === wanted[n]) &&
      words.every((word) => row.text.includes(word))
    );
  }

  function apply() {
    const wanted = state();
    const words = (wanted.q || "").toLowerCase().split(/\s+/).filter(Boolean);
    const counts = {};
    let total = 0;
    for (const row of rows) {
      const keep = fits(row, wanted, words);
      row.element.hidden = !keep;
      if (keep) {
        total += 1;
        counts[row.verdict] = (counts[row.verdict] || 0) + 1;
      }
    }
    /* Folded rows are opened by a filter that asks for them. */
    const asked = names.some((name) => wanted[name]);
    for (const fold of folds) {
      fold.open = asked && fold.querySelector("tr[data-verdict]:not([hidden])") !== null;
      fold.hidden = asked && !fold.open;
    }
    const parts = order.filter((v) => counts[v]).map((v) => counts[v] + " " + v);
    shown.textContent =
      (total === rows.length ? total + " rows" : total + " of " + rows.length + " rows") +
      (parts.length ? ": " + parts.join(", ") : ". No row fits these filters.");
  }

  function write() {
    const hash = new URLSearchParams(state()).toString();
    const address = window.location.href.replace(/#.*$/, "");
    window.history.replaceState(null, "", hash ? address + "#" + hash : address);
  }

  /* A plain #id names one row: then every row is shown, and the browser goes there. */
  function read() {
    const hash = window.location.hash.slice(1);
    const filtered = hash.includes("=");
    const wanted = new URLSearchParams(filtered ? hash : "");
    for (const name of names) {
      form.elements[name].value = wanted.get(name) || "";
    }
    apply();
    if (filtered) form.scrollIntoView({ block: "start", behavior: "instant" });
    else if (hash) show(document.getElementById(hash));
  }

  function show(row) {
    const fold = row?.closest("details.rx-pending");
    if (fold) fold.open = true;
    row?.scrollIntoView({ block: "center", behavior: "instant" });
  }

  let pause = 0;
  form.addEventListener("input", () => {
    window.clearTimeout(pause);
    pause = window.setTimeout(() => {
      apply();
      write();
    }, 120);
  });
  form.addEventListener("reset", () => {
    window.setTimeout(() => {
      apply();
      write();
    });
  });
  form.addEventListener("submit", (event) => event.preventDefault());
  window.addEventListener("hashchange", read);
  form.hidden = false;
  read();
})();
