// The number of frames over time, above their list; its cursor is the same as in the list and the plots.
import { element } from "../dom.js";

const HEIGHT = 40;

/** The overview of the frames; calls `point(seconds)` when the user points at a time. */
export function overview(point) {
  const canvas = element("canvas", { height: HEIGHT });
  const line = element("div", { class: "cursor", hidden: true });
  const root = element("div", { class: "overview", role: "slider", tabindex: 0, "aria-label": "Time in the capture, in seconds", "aria-valuemin": 0, hidden: true }, canvas, line);
  let known = null;
  let now = 0;

  function draw() {
    if (!known || root.hidden || root.clientWidth === 0) return;
    const scale = devicePixelRatio || 1;
    const width = root.clientWidth;
    [canvas.width, canvas.height] = [Math.round(width * scale), Math.round(HEIGHT * scale)];
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    const colours = known.kinds.map((kind) => colour(`--kind-${kind}`));
    const columns = inColumns(width);
    const most = Math.max(1, ...columns.map((column) => column.reduce((sum, count) => sum + count, 0)));
    columns.forEach((column, x) => {
      let y = HEIGHT;
      column.forEach((frames, kind) => {
        if (frames === 0) return;
        // Failures are visible, even one frame in a million.
        const high = Math.max((frames / most) * HEIGHT, kind === column.length - 1 ? 3 : 0.5);
        context.fillStyle = colours[kind];
        context.fillRect(x, y - high, 1, high);
        y -= high;
      });
    });
    place();
  }

  /** The counts for each column of pixels. */
  function inColumns(width) {
    const columns = Array.from({ length: width }, () => known.kinds.map(() => 0));
    known.parts.forEach((part, n) => {
      const from = Math.min(width - 1, Math.floor((n * known.part * width) / end()));
      const to = Math.max(from + 1, Math.min(width, Math.floor(((n + 1) * known.part * width) / end())));
      for (let x = from; x < to; x++) part.forEach((frames, kind) => (columns[x][kind] += frames / (to - from)));
    });
    return columns;
  }

  const end = () => Math.max(known.span, 1e-9);

  function colour(name) {
    root.style.color = `var(${name})`;
    return getComputedStyle(root).color;
  }

  function place() {
    line.hidden = !known;
    if (known) line.style.left = `${Math.min(1, now / end()) * (root.clientWidth - 2)}px`;
    root.setAttribute("aria-valuenow", now.toFixed(3));
    root.setAttribute("aria-valuetext", `${now.toFixed(3)} s`);
  }

  function at(event) {
    const box = root.getBoundingClientRect();
    return Math.max(0, Math.min(1, (event.clientX - box.left) / box.width)) * end();
  }

  root.addEventListener("click", (event) => known && point(at(event)));
  root.addEventListener("keydown", (event) => {
    if (!known) return;
    const step = { ArrowRight: 0.01, ArrowUp: 0.01, ArrowLeft: -0.01, ArrowDown: -0.01, PageUp: 0.1, PageDown: -0.1, Home: -1, End: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    point(Math.max(0, Math.min(known.span, now + step * known.span)));
  });
  new ResizeObserver(draw).observe(root);

  return {
    root,
    draw,
    /** Shows the frames of these captures; nothing if there are none. */
    show(told) {
      known = told;
      root.hidden = !told;
      now = 0;
      if (told) root.setAttribute("aria-valuemax", told.span.toFixed(3));
      draw();
    },
    set(seconds) {
      now = seconds;
      place();
    },
  };
}
