// Legend and words of a scene; what is drawn and turned is vtk.js's own matter.
(function () {
  const words = JSON.parse(document.getElementById("words").textContent);
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
    const shown = window.global?.renderWindow;
    const complete = (one) => one.getActors().length === words.actors.length;
    const renderer = shown?.getRenderers().find(complete);
    if (!renderer) {
      setTimeout(ready, 50);
      return;
    }
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
    again();
  }
  ready();
})();
