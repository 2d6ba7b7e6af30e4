/* Filters of the scoreboard, and the order of its rows. State stands in the address:
   #kind=claim&verdict=differs&sort=g. Each choice has its field in the data of a row. */
(function () {
  "use strict";
  const form = document.getElementById("rx-filter");
  const shown = document.getElementById("rx-shown");
  const board = document.getElementById("rx-board");
  if (!form || !shown || !board) return;

  const rows = Array.from(board.querySelectorAll("tr[data-verdict]"), (element) => ({
    element,
    body: element.parentNode,
    verdict: element.dataset.verdict,
    text: element.textContent.toLowerCase(),
  }));
  const heads = Array.from(board.querySelectorAll("th[data-sort]"));
  const folds = Array.from(board.querySelectorAll("details.rx-pending"));
  const names = ["chapter", "kind", "verdict", "readings", "test", "sort", "order", "q"];
  const chosen = names.slice(0, 5);
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
    const asked = [...chosen, "q"].some((name) => wanted[name]);
    for (const fold of folds) {
      fold.open = asked && fold.querySelector("tr[data-verdict]:not([hidden])") !== null;
      fold.hidden = asked && !fold.open;
    }
    const parts = order.filter((v) => counts[v]).map((v) => counts[v] + " " + v);
    shown.textContent =
      (total === rows.length ? total + " rows" : total + " of " + rows.length + " rows") +
      (parts.length ? ": " + parts.join(", ") : ". No row fits these filters.");
  }

  /* What a row is sorted by: a number where its cell begins with one, else words. */
  function key(row, column) {
    const cell = row.element.querySelector(column === "w" ? "th" : "td." + column);
    const said = cell.textContent.trim();
    if (column === "v") return order.indexOf(row.verdict);
    const number = "pg".includes(column) ? Number.parseFloat(said) : Number.NaN;
    return Number.isNaN(number) ? said.toLowerCase() : number;
  }

  /* Numbers come before words, and what is empty comes last, in either direction. */
  function compare(a, b, sign) {
    if (a === b) return 0;
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
    if (typeof a === "number") return sign * (a - b);
    if (!a || !b) return a ? -1 : 1;
    return sign * a.localeCompare(b, "en", { numeric: true });
  }

  let sorted = "";
  function sort() {
    const { sort: column, order: direction } = state();
    const asked = column ? column + (direction || "") : "";
    if (asked === sorted) return;
    sorted = asked;
    const sign = direction === "down" ? -1 : 1;
    const keyed = rows.map((row) => ({ row, key: column ? key(row, column) : 0 }));
    if (column) keyed.sort((a, b) => compare(a.key, b.key, sign));
    for (const { row } of keyed) row.body.append(row.element);
    for (const head of heads) {
      const way = sign < 0 ? "descending" : "ascending";
      head.setAttribute("aria-sort", head.dataset.sort === column ? way : "none");
    }
  }

  function update() {
    apply();
    sort();
    write();
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
    sort();
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
    pause = window.setTimeout(update, 120);
  });
  form.addEventListener("reset", () => {
    window.setTimeout(update);
  });
  form.addEventListener("submit", (event) => event.preventDefault());
  /* A head sorts by its column; once more, the other way round. */
  for (const head of heads) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const again = form.elements.sort.value === head.dataset.sort;
      const down = again && !form.elements.order.value;
      form.elements.sort.value = head.dataset.sort;
      form.elements.order.value = down ? "down" : "";
      update();
    });
  }
  window.addEventListener("hashchange", read);
  form.hidden = false;
  read();
})();
