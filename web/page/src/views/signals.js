import { button, counted, element, save, welcome } from "../dom.js";
import { COLOURS, plotOf } from "./plot.js";

const UNKNOWN =
  "No PDO whose mapping is known. It is known from the SDO traffic of a capture that shows how it is read or written, or from a description: drop the EDS of the device too.";
const HINT = "Drag to zoom, double-click to see all. A click sets a cursor, with Shift the other one; in the focused plot the arrow keys move, + and − zoom, 0 shows all, A and B set the cursors in the middle.";

/** The view of the values of PDOs over time. */
export function signalsView(app, root) {
  let shown = null;
  let known = null;
  let plot = null;
  let chosen = [];
  /** The times of the cursors in seconds; the first one is common to all views. */
  let marks = [null, null];
  const filter = element("input", { type: "search", id: "signal-filter", placeholder: "Filter by name", "aria-label": "Filter of the signals" });
  const choice = element("fieldset", { class: "signals" });
  const area = element("div", { class: "plot", id: "plot", tabindex: 0, role: "group", "aria-label": "Values over time" });
  const readings = element("table", { class: "readings", id: "readings" });
  const times = ["A", "B"].map((name, n) => {
    const input = element("input", { type: "text", inputmode: "decimal", id: `cursor-${name}`, size: 10 });
    input.addEventListener("change", () => mark(n, input.value.trim() === "" ? null : Number(input.value.replace(",", "."))));
    return input;
  });
  const second = element("input", { type: "checkbox", id: "second-cursor" });
  const view = { refresh, shown: show, point: (seconds) => mark(0, seconds, false), painted: () => plot?.paint() };

  async function gather() {
    known = await app.run("plots", "plots", {}, "Reading values");
    if (!known) return;
    if (known.columns.length === 0) return root.replaceChildren(welcome(UNKNOWN));
    const wanted = (app.state.get("signals") ?? "0").split(",").map(Number);
    chosen = wanted.filter((n) => n in known.columns);
    build();
  }

  function build() {
    const plain = (name, act) => button(name, act, { class: "plain" });
    const thinned = known.thinned > 1 ? `; of ${known.thinned} values each the least and the greatest` : "";
    root.replaceChildren(
      element("div", { class: "bar" }, filter, plain("Whole capture", () => plot.whole()), plain("CSV", csv), plain("PNG", png),
        element("label", {}, "A [s] ", times[0]), element("label", {}, "B [s] ", times[1]), element("label", {}, second, " clicks set B"),
        element("span", { class: "shown" }, `${counted(known.columns.length, "signal")}${thinned}`)),
      element("div", { class: "split" }, choice, element("div", { class: "drawn" }, area, element("div", { class: "scroll" }, readings), element("p", { class: "note" }, HINT))),
    );
    plot ??= plotOf(area, { points, marks: () => marks, mark: (seconds, other) => mark((second.checked || other) ? 1 : 0, seconds) });
    filter.oninput = list;
    list();
    draw();
  }

  const points = (column, from, to, parts) => app.engine.call("points", { column, from, to, parts });

  function list() {
    const wanted = filter.value.toLowerCase();
    const boxes = known.columns.flatMap((column, n) => {
      if (!column.name.toLowerCase().includes(wanted)) return [];
      const box = element("input", { type: "checkbox", checked: chosen.includes(n) });
      box.addEventListener("change", () => toggle(n, box.checked));
      return [element("label", { title: counted(column.values, "value"), "data-column": n }, box, element("span", { class: "swatch" }), column.name)];
    });
    choice.replaceChildren(element("legend", { class: "unseen" }, "Signals to draw"), ...boxes);
    paint();
  }

  /** Shows which signals are drawn, and in which colour. The boxes stay, and with them the focus. */
  function paint() {
    for (const label of choice.querySelectorAll("label")) {
      const place = chosen.indexOf(Number(label.dataset.column));
      label.querySelector("input").checked = place >= 0;
      label.querySelector(".swatch").style.background = place >= 0 ? COLOURS[place] : "transparent";
    }
  }

  function toggle(column, on) {
    chosen = on ? [...chosen, column].slice(-COLOURS.length) : chosen.filter((other) => other !== column);
    // The address contains the positions of the columns, as their names are data of the capture.
    app.state.set({ signals: chosen.join(",") });
    paint();
    draw();
  }

  function draw() {
    plot.draw(chosen.map((n) => ({ column: n, ...known.columns[n] })));
    read();
  }

  /** Sets a cursor; the first one is passed to the other views, unless it comes from them. */
  function mark(n, seconds, tell = true) {
    marks[n] = Number.isFinite(seconds) ? seconds : null;
    if (tell && n === 0 && marks[0] !== null) app.point(marks[0], view);
    times[n].value = marks[n] === null ? "" : String(rounded(marks[n]));
    if (!known) return;
    plot?.redraw();
    read();
  }

  const rounded = (value) => Math.round(value * 1e6) / 1e6;

  /** The last value of a signal before a time. */
  async function valueAt(column, seconds) {
    if (seconds === null) return null;
    const around = await points(column, seconds, seconds, 2);
    let value = null;
    for (let n = 0; n < around.length && around[n] <= seconds; n += 2) value = around[n + 1];
    return value;
  }

  /** Shows the values of the signals at the cursors, and their differences. */
  async function read() {
    const [columns, at] = [chosen, [...marks]];
    const values = await Promise.all(columns.map((column) => Promise.all(at.map((seconds) => valueAt(column, seconds)))));
    // The cursor was moved meanwhile.
    if (columns !== chosen || at.some((seconds, n) => seconds !== marks[n])) return;
    const cell = (value) => element("td", { class: "number" }, value === null ? "" : String(rounded(value)));
    const row = (name, [a, b]) => element("tr", {}, element("th", { scope: "row" }, name), cell(a), cell(b), cell(a === null || b === null ? null : b - a));
    const head = element("tr", {}, ["Signal", "A", "B", "B − A"].map((name) => element("th", { scope: "col" }, name)));
    const rows = columns.map((n, index) => row(known.columns[n].name, values[index]));
    readings.replaceChildren(element("thead", {}, head), element("tbody", {}, row("time [s]", at), ...rows));
  }

  /** Saves all values in the form of `canvass signals`. */
  async function csv() {
    const end = await app.run("export", "export", { wish: { what: "signals", format: "csv" } }, "Writing");
    if (end) save("signals.csv", end.blob);
  }

  async function png() {
    save("signals.png", await plot.picture());
  }

  function refresh() {
    shown = known = null;
    plot?.drop();
    plot = null;
    marks = [null, null];
    times.forEach((input) => (input.value = ""));
    root.replaceChildren(welcome(app.captures.length > 0 ? "" : "Open a capture first."));
  }

  function show() {
    if (!app.summary || shown === app.summary) return;
    shown = app.summary;
    gather();
  }

  return view;
}
