"use strict";
// A 3-D scene or film is loaded when its reader opens it, and dressed in the page's theme.

(() => {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const theme = () => {
    const chosen = document.body.dataset.theme;
    return chosen === "dark" || (chosen !== "light" && dark.matches) ? "dark" : "light";
  };
  const frames = () => document.querySelectorAll(".raxel-scene iframe[src]");
  const tell = () => {
    for (const frame of frames())
      frame.contentWindow.postMessage({ raxelTheme: theme() }, "*");
  };
  const load = (fold) => {
    const frame = fold.querySelector("iframe");
    if (fold.open && !frame.hasAttribute("src"))
      frame.setAttribute("src", `${frame.dataset.src}#${theme()}`);
  };
  for (const fold of document.querySelectorAll("details.raxel-scene")) {
    fold.addEventListener("toggle", () => load(fold));
    // A browser may bring a page back with the fold open.
    load(fold);
  }
  // A film says how high it is, in the width that it has.
  window.addEventListener("message", (told) => {
    const height = Number(told.data?.raxelHeight);
    for (const frame of frames())
      if (height > 0 && frame.contentWindow === told.source)
        frame.style.height = `${Math.ceil(height) + 24}px`;
  });
  dark.addEventListener("change", tell);
  new MutationObserver(tell).observe(document.body, {
    attributes: true,
    attributeFilter: ["data-theme"],
  });
})();
