import uPlot from "uplot";
import { count, element, save } from "../dom.js";

const COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd", "#17becf", "#8c564b", "#e377c2"];
/** More axes than this are no help. */
const MOST = COLOURS.length;

/** The values of PDOs over time. */
export function signalsView(app, root) {
  let shown = null;
  let known = null;
  let plot = null;
  let chosen = [];
  /** Cursors: times in seconds. */
  let marks = [];
  const filter = element("input", { type: "text", id: "signal-filter", placeholder: "Filter by name", "aria-label": "Filter of the signals" });
  const choice = element("fieldset", { class: "signals" });
  const area = element("div", { class: "plot", id: "plot", tabindex: 0, role: "img", "aria-label": "Values over time" });
  const readings = element("table", { class: "readings", id: "readings" });

  async function gather() {
    area.replaceChildren();
    readings.replaceChildren();
    known = await app.run("plots", "plots", {}, "Reading values");
    if (!known) return;
    if (known.columns.length === 0) {
      const text = "No PDO whose mapping is known. It is known from the SDO traffic of a capture that shows how it is read or written, or from a description: drop the EDS of the device too.";
      root.replaceChildren(element("div", { class: "welcome" }, element("p", {}, text)));
      return;
    }
    const wanted = (app.state.get("signals") ?? "").split("|").filter(Boolean);
    chosen = known.columns.map((column, n) => n).filter((n) => wanted.includes(known.columns[n].name));
    if (chosen.length === 0) chosen = [0];
    build();
  }

  function build() {
    const button = (name, act) => element("button", { type: "button", class: "plain", onclick: act }, name);
    const thinned = known.thinned > 1 ? `; of ${known.thinned} values each the least and the greatest` : "";
    root.replaceChildren(
      element("div", { class: "bar" }, filter, button("Whole capture", whole), button("CSV", csv), button("PNG", png),
        element("span", { class: "shown" }, `${known.columns.length} signals${thinned}. Drag to zoom, click to set cursor A, with Shift cursor B.`)),
      element("div", { class: "split" }, choice, element("div", { class: "drawn" }, area, element("div", { class: "scroll" }, readings))),
    );
    filter.oninput = list;
    list();
    draw();
  }

  function list() {
    const wanted = filter.value.toLowerCase();
    const boxes = known.columns.flatMap((column, n) => {
      if (!column.name.toLowerCase().includes(wanted)) return [];
      const box = element("input", { type: "checkbox", checked: chosen.includes(n) });
      box.checked = chosen.includes(n);
      box.addEventListener("change", () => toggle(n, box.checked));
      return [element("label", { title: `${count(column.values)} values` }, box, ` ${column.name}`)];
    });
    choice.replaceChildren(element("legend", { class: "unseen" }, "Signals to draw"), ...boxes);
  }

  function toggle(column, on) {
    chosen = on ? [...chosen, column].slice(-MOST) : chosen.filter((other) => other !== column);
    app.state.set({ signals: chosen.map((n) => known.columns[n].name).join("|") });
    list();
    draw();
  }

  const range = () => (plot ? [plot.scales.x.min, plot.scales.x.max] : [-Infinity, Infinity]);

  /** The values of a span, on one axis of time. */
  async function data(from, to) {
    const parts = Math.max(200, area.clientWidth);
    const all = await Promise.all(chosen.map((column) => app.engine.call("points", { column, from, to, parts })));
    const tables = all.map((points) => {
      const times = [];
      const values = [];
      for (let n = 0; n < points.length; n += 2) {
        if (points[n] === times.at(-1)) values[values.length - 1] = points[n + 1];
        else {
          times.push(points[n]);
          values.push(points[n + 1]);
        }
      }
      return [times, values];
    });
    return tables.length > 0 ? uPlot.join(tables) : [[0, 1]];
  }

  async function draw(from = -Infinity, to = Infinity) {
    const drawn = await data(from, to);
    plot?.destroy();
    const units = [...new Set(chosen.map((n) => known.columns[n].unit))];
    const text = getComputedStyle(root).getPropertyValue("color");
    const grid = { stroke: "rgba(128,128,128,0.25)", width: 1 };
    const axes = units.map((unit, n) => ({ scale: scale(unit), label: unit || "no unit", side: n % 2 === 0 ? 3 : 1, stroke: text, grid: n === 0 ? grid : { show: false }, size: 70 }));
    const series = chosen.map((n, at) => ({ label: known.columns[n].name, stroke: COLOURS[at], width: 1.5, scale: scale(known.columns[n].unit), spanGaps: true, points: { show: false } }));
    plot = new uPlot(
      {
        width: Math.max(200, area.clientWidth),
        height: Math.max(200, area.clientHeight - 4),
        legend: { show: false },
        cursor: { drag: { x: true, y: false, setScale: false } },
        scales: { x: { time: false, ...(Number.isFinite(from) ? { min: from, max: to } : {}) } },
        axes: [{ stroke: text, grid, label: "s" }, ...axes],
        series: [{}, ...series],
        hooks: { setSelect: [zoomed], draw: [drawMarks], ready: [listen] },
      },
      drawn,
      area,
    );
    read();
  }

  const scale = (unit) => `unit ${unit}`;

  function zoomed(self) {
    const { left, width } = self.select;
    if (width < 4) return;
    draw(self.posToVal(left, "x"), self.posToVal(left + width, "x"));
  }

  const whole = () => draw();

  function listen(self) {
    self.over.addEventListener("click", (event) => {
      const at = self.posToVal(event.offsetX, "x");
      if (event.shiftKey) marks[1] = at;
      else marks[0] = at;
      self.redraw();
      read();
    });
    self.over.addEventListener("dblclick", whole);
  }

  area.addEventListener("keydown", (event) => {
    const [min, max] = range();
    const span = max - min;
    const to = { ArrowLeft: [min - span / 4, max - span / 4], ArrowRight: [min + span / 4, max + span / 4], "+": [min + span / 4, max - span / 4], "-": [min - span / 2, max + span / 2] }[event.key];
    if (event.key === "0") whole();
    else if (to) draw(...to);
    else return;
    event.preventDefault();
  });

  function drawMarks(self) {
    marks.forEach((time, n) => {
      const x = self.valToPos(time, "x", true);
      const { ctx, bbox } = self;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = n === 0 ? "#c2185b" : "#00838f";
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText("AB"[n], x + 3, bbox.top + 12);
      ctx.restore();
    });
  }

  /** What the signals are at the cursors, and how they differ. */
  function read() {
    const at = (values, time) => {
      const [times] = plot.data;
      let value = null;
      for (let n = 0; n < times.length && times[n] <= time; n++) value = values[n] ?? value;
      return value;
    };
    const cell = (value) => element("td", { class: "number" }, value === null || value === undefined ? "" : String(Math.round(value * 1e6) / 1e6));
    const row = (name, a, b) => element("tr", {}, element("th", { scope: "row" }, name), cell(a), cell(b), cell(a !== null && b !== null && a !== undefined && b !== undefined ? b - a : null));
    const head = element("tr", {}, ["", "A", "B", "B − A"].map((name) => element("th", { scope: "col" }, name)));
    const rows = chosen.map((n, index) => row(known.columns[n].name, ...[0, 1].map((mark) => (marks[mark] === undefined ? null : at(plot.data[index + 1], marks[mark])))));
    readings.replaceChildren(element("thead", {}, head), element("tbody", {}, row("time [s]", marks[0], marks[1]), ...rows));
  }

  /** As `canvass signals` prints it, all of it. */
  async function csv() {
    const end = await app.run("export", "export", { wish: { what: "signals", format: "csv" } }, "Writing");
    if (end) save("signals.csv", end.blob);
  }

  function png() {
    plot.ctx.canvas.toBlob((blob) => save("signals.png", blob));
  }

  new ResizeObserver(() => plot && plot.setSize({ width: Math.max(200, area.clientWidth), height: Math.max(200, area.clientHeight - 4) })).observe(area);

  return {
    refresh() {
      shown = null;
      plot?.destroy();
      plot = null;
      marks = [];
      const text = app.captures.length > 0 ? "" : "Open a capture first.";
      root.replaceChildren(element("div", { class: "welcome" }, element("p", {}, text)));
    },
    shown() {
      if (!app.summary || shown === app.summary) return;
      shown = app.summary;
      gather();
    },
  };
}
