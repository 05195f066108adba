"use strict";
// The pictures are in the page once, in the gallery; the slider shows them by reference. What is
// chosen stands behind the # of the address, as in #left=flat&right=curved&split=30.
(() => {
  const get = (id) => document.getElementById(id);
  const [stage, split] = [get("stage"), get("split")];
  const sides = { left: get("left"), right: get("right") };
  const keys = new Set(Array.from(sides.left.options, (option) => option.value));

  function show() {
    const words = {};
    for (const [side, select] of Object.entries(sides)) {
      const from = get("picture-" + select.value);
      const to = get(side + "-picture");
      to.src = from.src;
      to.alt = from.alt;
      words[side] = select.selectedOptions[0].text;
    }
    const percent = Number(split.value);
    stage.style.setProperty("--split", percent + "%");
    split.setAttribute("aria-valuetext", `${percent} % ${words.left}, ${100 - percent} % ${words.right}`);
  }

  function remember() {
    const state = { left: sides.left.value, right: sides.right.value, split: split.value };
    try {
      history.replaceState(null, "", "#" + new URLSearchParams(state));
    } catch {
      // some browsers do not let a local page change its address
    }
  }

  function change() {
    show();
    remember();
  }

  function recall() {
    const state = new URLSearchParams(location.hash.slice(1));
    for (const [side, usual] of [["left", "flat"], ["right", "curved"]]) {
      const key = state.get(side);
      sides[side].value = keys.has(key) ? key : usual;
    }
    const percent = Number(state.get("split") ?? 50);
    split.value = Number.isFinite(percent) ? percent : 50;
    show();
  }

  function drag(event) {
    if (event.buttons & 1) {
      const box = stage.getBoundingClientRect();
      split.value = (100 * (event.clientX - box.left)) / box.width;
      change();
    }
  }

  split.addEventListener("input", change);
  sides.left.addEventListener("change", change);
  sides.right.addEventListener("change", change);
  stage.addEventListener("pointermove", drag);
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    drag(event);
  });
  stage.addEventListener("dragstart", (event) => event.preventDefault());
  window.addEventListener("hashchange", recall);
  get("slider").hidden = false;
  recall();
})();
