import { button, byId, count, element } from "../dom.js";
import { List } from "../list.js";
import { suggest } from "../suggest.js";
import { showDetails } from "./details.js";
import { overview } from "./overview.js";

const NAMES = {
  time: "Time [s]", delta: "After [s]", absolute: "In the capture", place: "Line", channel: "Channel", node: "Node",
  service: "Service", id: "CAN-ID", data: "Data", text: "Meaning",
};
const COLUMNS = Object.keys(NAMES);
/** Columns that are hidden at first; a phone has room for few. */
const HIDDEN = ["delta", "absolute"];
const HIDDEN_ON_PHONE = [...HIDDEN, "place", "channel", "data"];

/** The view of all frames of the captures. */
export function traceView(app, root) {
  let shown = null;
  /** A time to which the list scrolls once it is visible. */
  let waiting = null;
  const status = element("span", { class: "shown", role: "status" });
  const mistake = element("pre", { id: "filter-mistake", class: "mistake", hidden: true });
  const filter = input("filter", "Filter, such as service=sdo and node in 1..8", { "aria-describedby": "filter-mistake" });
  const search = input("search", "Search meaning, CAN-ID, data", { type: "search" });
  const jump = input("jump", "Go to [s]", { title: "Seconds since the first frame or as in the capture, or the time of day in UTC, such as 22:13:45" });
  /** What became of the last search or jump. */
  const outcome = element("span", { class: "outcome", role: "status" });
  /** What the outcome will be when the row that was found is chosen. */
  let told = "";
  const details = element("aside", { id: "details", "aria-label": "The frame chosen" });
  const grid = element("div", { id: "frames", class: "list" });
  const time = overview((seconds) => jumpTo(seconds));
  const hidden = new Set(app.state.get("hide")?.split(",") ?? (matchMedia("(max-width: 46rem)").matches ? HIDDEN_ON_PHONE : HIDDEN));
  const head = element("div", { class: "row head", role: "row" }, COLUMNS.map((column) => element("span", { class: `cell ${column}`, role: "columnheader" }, NAMES[column])));
  const list = new List(grid, { head, fetch: rows, draw, choose, label: "Frames" });
  const view = { refresh, shown: show, point };

  function input(id, label, more = {}) {
    return element("input", { id, type: "text", placeholder: label, "aria-label": label, autocomplete: "off", spellcheck: "false", ...more });
  }

  function build() {
    const find = (backwards) => () => look(backwards);
    const back = button("▲", find(true), { class: "plain", "aria-label": "Find the one before" });
    const on = button("▼", find(false), { class: "plain", "aria-label": "Find the next" });
    const words = suggest(filter, (text) => app.engine.call("completions", { text }));
    root.replaceChildren(
      element("div", { class: "bar" }, words, element("span", { class: "find" }, search, back, on), jump, outcome, columns(), status),
      mistake,
      time.root,
      element("div", { class: "trace" }, element("div", { class: "table" }, grid), details),
    );
    filter.value = app.state.get("filter") ?? "";
    filter.addEventListener("input", () => select());
    search.addEventListener("keydown", (event) => event.key === "Enter" && look(event.shiftKey));
    search.addEventListener("input", () => outcome.replaceChildren());
    jump.addEventListener("input", () => outcome.replaceChildren());
    jump.addEventListener("keydown", (event) => event.key === "Enter" && jumpToTyped());
    root.addEventListener("keydown", shortcut);
    hide();
  }

  /** The choice of visible columns. */
  function columns() {
    const boxes = COLUMNS.map((column) => {
      const box = element("input", { type: "checkbox", checked: !hidden.has(column) });
      box.addEventListener("change", () => {
        if (box.checked) hidden.delete(column);
        else hidden.add(column);
        app.state.set({ hide: [...hidden].join(",") || "none" });
        hide();
      });
      return element("label", {}, box, ` ${NAMES[column]}`);
    });
    const menu = element("details", { class: "menu" }, element("summary", {}, "Columns"), element("fieldset", {}, element("legend", { class: "unseen" }, "Columns"), boxes));
    menu.addEventListener("keydown", (event) => event.key === "Escape" && ((menu.open = false), menu.firstChild.focus()));
    return menu;
  }

  const hide = () => COLUMNS.forEach((column) => grid.classList.toggle(`no-${column}`, hidden.has(column)));

  /** Keyboard shortcuts, as in pagers. */
  function shortcut(event) {
    if (event.target.matches("input, select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const to = { "/": search, f: filter, g: jump }[event.key];
    if (to) to.focus();
    else if (event.key === "n") look(false);
    else if (event.key === "N") look(true);
    else return;
    event.preventDefault();
  }

  function rows(from, amount) {
    return app.engine.call("rows", { from, count: amount });
  }

  function draw(row, known) {
    if (!row.firstChild) row.append(...COLUMNS.map((column) => element("span", { class: `cell ${column}`, role: "gridcell" })));
    COLUMNS.forEach((column, n) => {
      const text = String(known?.[column] ?? "");
      if (row.children[n].textContent !== text) row.children[n].textContent = text;
    });
    row.dataset.service = known?.service ?? "";
    row.classList.toggle("bad", known?.bad ?? false);
  }

  /** Goes to a time as it was typed. */
  async function jumpToTyped() {
    const seconds = typedTime(jump.value, app.summary?.start ?? 0);
    outcome.textContent = Number.isNaN(seconds) ? "expected seconds, such as 12.5, or a time of day, such as 22:13:45" : "";
    await jumpTo(seconds);
  }

  /** Selects a row; `quiet`: another view has moved the cursor to its time. */
  async function choose(row, quiet) {
    outcome.textContent = told;
    told = "";
    app.state.set({ row: row.row });
    time.set(Number(row.time));
    if (!quiet) app.point(Number(row.time), view);
    const known = await app.engine.call("details", { row: row.row });
    showDetails(details, known, row, { goTo, jumpTo });
  }

  /** Goes to a frame, by its index among all frames. */
  async function goTo(row, quiet = false) {
    list.go(await app.engine.call("rank", { row }), quiet);
  }

  async function jumpTo(seconds, quiet = false) {
    if (app.summary && Number.isFinite(seconds)) await goTo(await app.engine.call("rowAt", { seconds }), quiet);
  }

  async function look(backwards) {
    if (!search.value || list.length === 0) return;
    const asked = { filter: app.state.get("filter") ?? "", text: search.value, backwards };
    const from = app.state.get("row") === undefined ? undefined : Number(app.state.get("row"));
    let end = await app.run("find", "find", { ...asked, from }, "Searching");
    if (!end) return;
    told = "";
    if (typeof end.found !== "number" && from !== undefined) {
      end = await app.run("find", "find", asked, "Searching");
      if (!end) return;
      told = backwards ? "on from the end" : "on from the beginning";
    }
    if (typeof end.found === "number") return goTo(end.found);
    told = "";
    outcome.textContent = asked.filter ? "in no frame that passes the filter" : "in no frame";
  }

  /** Applies the filter; a wrong filter leaves the rows unchanged. */
  async function select() {
    const text = filter.value;
    const checked = await app.engine.call("checkFilter", { text });
    if (text !== filter.value) return;
    mistake.hidden = checked.ok;
    filter.setAttribute("aria-invalid", !checked.ok);
    if (!checked.ok) {
      const found = checked.found ? `, found "${checked.found}"` : "";
      mistake.textContent = `${text}\n${" ".repeat(checked.column - 1)}^ expected ${checked.expected}${found}`;
      return;
    }
    app.state.set({ filter: text });
    if (!app.summary) return;
    let told = false;
    const tell = (at) => {
      status.textContent = `${count(at.rows)} of ${count(at.all)} frames`;
      if (told) list.grow(at.rows);
      else list.reset(at.rows);
      told = true;
    };
    const end = await app.engine.call("choose", { filter: text, text: "" }, tell);
    if (end.cancelled) return;
    tell(end);
    await keep();
  }

  /** Keeps the chosen frame after the filter has changed: selected if it passes, otherwise its place. */
  async function keep() {
    const chosen = app.state.get("row");
    if (chosen === undefined || list.length === 0) return;
    const at = await app.engine.call("rank", { row: Number(chosen) });
    const passes = at < list.length && (await list.row(at))?.row === Number(chosen);
    list.place(at, passes);
    outcome.textContent = passes ? "" : "the frame chosen does not pass the filter";
  }

  function refresh() {
    shown = null;
    list.reset(0);
    time.show(null);
    details.replaceChildren();
    status.textContent = app.summary ? "" : "Open a capture first.";
  }

  /** Follows the cursor of another view. */
  function point(seconds) {
    time.set(seconds);
    waiting = seconds;
  }

  async function show() {
    if (!app.summary) return;
    if (shown !== app.summary) {
      const { summary } = app;
      if (!(await app.run("index", "index", {}, "Working out the list")) || summary !== app.summary || shown === summary) return;
      shown = summary;
      time.show(await app.engine.call("overview"));
      await select();
      const row = Number(app.state.get("row") ?? 0);
      if (row > 0 && waiting === null) await goTo(row);
      if (waiting === null && row === 0) list.place(0, app.state.get("row") !== undefined);
      if (app.summary.leftOut > 0) app.say(`The list holds the first ${count(app.summary.frames)} frames; the diagnosis has all`);
    }
    const filtered = app.state.get("filter") ?? "";
    if (filter.value !== filtered) {
      filter.value = filtered;
      await select();
    }
    if (waiting !== null) await jumpTo(waiting, true);
    waiting = null;
    byId("frames").focus({ preventScroll: true });
  }

  build();
  return view;
}

/** Seconds since the first frame, from seconds since it, seconds as in the capture, or a time of day in UTC; `start` is the time of
 * the first frame. NaN if it is no time. */
export function typedTime(text, start) {
  const typed = text.trim().replace(",", ".");
  const clock = /^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$/.exec(typed);
  if (clock) {
    const [hours, minutes, seconds] = clock.slice(1).map((part) => Number(part ?? 0));
    const day = 86_400;
    const wanted = hours * 3_600 + minutes * 60 + seconds - (start % day);
    // The first such time in the capture.
    return wanted < -1e-6 ? wanted + day : Math.max(0, wanted);
  }
  const seconds = typed === "" ? NaN : Number(typed);
  // A recording lasts less than the time since 1970.
  return seconds >= start && start > 1e8 ? seconds - start : seconds;
}
