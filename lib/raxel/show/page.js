// Legend, words and theme of a scene; what is drawn and turned is vtk.js's own matter.
// The theme is that behind # in the address, else the reader's; the page around this one
// may send another, as { raxelTheme: "dark" }.
(function () {
  const words = JSON.parse(document.getElementById("words").textContent);
  const prefers = window.matchMedia("(prefers-color-scheme: dark)");
  let sent = "";
  const asked = () =>
    sent || location.hash.slice(1) || (prefers.matches ? "dark" : "light");
  const parts = (colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16) / 255);
  let renderer = null;
  let shown = null;

  function wear(name) {
    const theme = words.themes[Object.hasOwn(words.themes, name) ? name : "light"];
    const style = document.documentElement.style;
    style.setProperty("--paper", theme.background);
    style.setProperty("--ink", theme.ink);
    if (!renderer) return;
    renderer.setBackground(...parts(theme.background));
    renderer.getActors().forEach((actor, k) => {
      if (words.inked[k]) actor.getProperty().setColor(...parts(theme.ink));
    });
    shown.render();
  }

  wear(asked());
  prefers.addEventListener("change", () => wear(asked()));
  window.addEventListener("message", (told) => {
    sent = told.data?.raxelTheme || sent;
    wear(asked());
  });

  const layer = document.querySelector(".words");
  const spans = words.texts.map((word) => {
    const span = document.createElement("span");
    span.textContent = word.text;
    span.style.color = word.colour;
    span.style.fontSize = word.size + "px";
    layer.appendChild(span);
    return span;
  });

  function place(renderer) {
    const { clientWidth: width, clientHeight: height } = layer.parentNode;
    words.texts.forEach((word, k) => {
      const [x, y, depth] = renderer.worldToNormalizedDisplay(...word.at, width / height);
      spans[k].hidden = hidden.has(word.label) || depth > 1;
      spans[k].style.left = x * width + "px";
      spans[k].style.top = (1 - y) * height + "px";
    });
  }

  const hidden = new Set();
  function ready() {
    shown = window.global?.renderWindow;
    const complete = (one) => one.getActors().length === words.actors.length;
    const found = shown?.getRenderers().find(complete);
    if (!found) {
      setTimeout(ready, 50);
      return;
    }
    renderer = found;
    const actors = renderer.getActors();
    const again = () => place(renderer);
    renderer.getActiveCamera().onModified(again);
    new ResizeObserver(again).observe(layer.parentNode);
    document.querySelectorAll(".legend input").forEach((box) => {
      box.addEventListener("change", () => {
        box.checked ? hidden.delete(box.value) : hidden.add(box.value);
        words.actors.forEach((label, k) => {
          if (label === box.value) actors[k].setVisibility(box.checked);
        });
        shown.render();
        again();
      });
    });
    wear(asked());
    again();
  }
  ready();
})();
