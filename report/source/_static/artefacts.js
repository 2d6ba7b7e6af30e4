"use strict";
// The extensions on the page of all figures and tables: folded, or all of them open.

(() => {
  const form = document.getElementById("rx-extensions");
  if (!form) return;
  const folds = document.querySelectorAll("details.rx-more");
  const box = form.elements.shown;

  const apply = () => {
    for (const fold of folds) fold.open = box.checked;
  };
  // An address may name an extension: its fold is opened.
  const reach = () => {
    const named = document.getElementById(window.location.hash.slice(1));
    const fold = named?.closest("details.rx-more");
    if (!fold) return;
    fold.open = true;
    named.scrollIntoView();
  };

  box.addEventListener("change", apply);
  window.addEventListener("hashchange", reach);
  form.hidden = false;
  // A browser may bring a page back with the switch on.
  apply();
  reach();
})();
