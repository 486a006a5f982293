import { byId, count, element } from "../dom.js";
import { List } from "../list.js";
import { showDetails } from "./details.js";

const COLUMNS = ["time", "place", "channel", "node", "service", "id", "data", "text"];
const NAMES = { time: "Time [s]", place: "Line", channel: "Channel", node: "Node", service: "Service", id: "CAN-ID", data: "Data", text: "Meaning" };
/** What a filter can begin with; the rest the language says itself. */
const WORDS = [
  "node=", "service=sdo", "service=pdo", "service=emcy", "service=nmt", "service in heartbeat,boot-up", "id=181h",
  "index=0x6004", "sub=", "len=", "channel=", "abort", "emcy", "violation", "remote", "extended", "error", "not service=pdo",
];

/** All frames of the captures. */
export function traceView(app, root) {
  let shown = null;
  const list = { current: null };
  const status = element("span", { class: "shown", role: "status" });
  const mistake = element("pre", { id: "filter-mistake", class: "mistake", hidden: true });
  const filter = input("filter", "Filter, such as service=sdo and node in 1..8", { list: "filter-words", "aria-describedby": "filter-mistake" });
  const search = input("search", "Search the meaning");
  const jump = input("jump", "Go to [s]", { inputmode: "decimal" });
  const details = element("aside", { id: "details", "aria-label": "The frame chosen" });
  const grid = element("div", { id: "frames", class: "list" });

  function input(id, label, more = {}) {
    return element("input", { id, type: "text", placeholder: label, "aria-label": label, autocomplete: "off", spellcheck: "false", ...more });
  }

  function build() {
    const words = element("datalist", { id: "filter-words" }, WORDS.map((value) => element("option", { value })));
    const find = (backwards) => () => look(backwards);
    const back = element("button", { type: "button", class: "plain", onclick: find(true), "aria-label": "Find the one before" }, "▲");
    const on = element("button", { type: "button", class: "plain", onclick: find(false), "aria-label": "Find the next" }, "▼");
    root.replaceChildren(
      element("div", { class: "bar" }, filter, words, search, back, on, jump, status),
      mistake,
      element("div", { class: "trace" }, element("div", { class: "table" }, head(), grid), details),
    );
    list.current = new List(grid, { fetch: rows, draw, choose, label: "Frames" });
    filter.value = app.state.get("filter") ?? "";
    filter.addEventListener("input", () => select());
    search.addEventListener("keydown", (event) => event.key === "Enter" && look(event.shiftKey));
    jump.addEventListener("keydown", (event) => event.key === "Enter" && jumpTo(Number(jump.value.replace(",", "."))));
    root.addEventListener("keydown", shortcut);
  }

  /** As pagers have them. */
  function shortcut(event) {
    if (event.target.matches("input, select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const to = { "/": search, f: filter, g: jump }[event.key];
    if (to) to.focus();
    else if (event.key === "n") look(false);
    else if (event.key === "N") look(true);
    else return;
    event.preventDefault();
  }

  function head() {
    const cells = COLUMNS.map((column) => element("span", { class: `cell ${column}`, role: "columnheader" }, NAMES[column]));
    return element("div", { class: "row head", role: "row" }, cells);
  }

  const rows = (from, amount) => app.engine.call("rows", { from, count: amount });

  function draw(row, known) {
    if (!row.firstChild) row.append(...COLUMNS.map((column) => element("span", { class: `cell ${column}`, role: "gridcell" })));
    COLUMNS.forEach((column, n) => {
      const text = String(known?.[column] ?? "");
      if (row.children[n].textContent !== text) row.children[n].textContent = text;
    });
    row.dataset.service = known?.service ?? "";
    row.classList.toggle("bad", known?.bad ?? false);
  }

  async function choose(at, row) {
    app.state.set({ row: row.row });
    const known = await app.engine.call("details", { row: row.row });
    showDetails(details, known, row, goTo);
  }

  /** Goes to a frame, by its place among all. */
  async function goTo(row) {
    list.current.go(await app.engine.call("rank", { row }));
  }

  async function jumpTo(seconds) {
    if (Number.isFinite(seconds)) await goTo(await app.engine.call("rowAt", { seconds }));
  }

  async function look(backwards) {
    if (!search.value || list.current.length === 0) return;
    const row = Number(app.state.get("row") ?? -1);
    const args = { text: search.value, from: Math.max(0, row), backwards };
    const end = await app.run("find", "find", args, "Searching");
    if (!end) return;
    if (typeof end.found === "number") await goTo(end.found);
    else app.say(`"${search.value}" is in no frame ${backwards ? "before" : "after"} this one`);
  }

  /** Applies the filter; one that is none leaves the rows as they are. */
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
    let told = false;
    const tell = (at) => {
      status.textContent = `${count(at.rows)} of ${count(at.all)} frames`;
      if (told) list.current.grow(at.rows);
      else list.current.reset(at.rows);
      told = true;
    };
    const end = await app.engine.call("choose", { filter: text, text: "" }, tell);
    if (!end.cancelled) tell(end);
  }

  build();
  return {
    goTo,
    jumpTo,
    refresh() {
      shown = null;
      list.current.reset(0);
      details.replaceChildren();
      status.textContent = "";
    },
    async shown() {
      if (!app.summary || shown === app.summary) return;
      shown = app.summary;
      await select();
      const row = Number(app.state.get("row") ?? 0);
      if (row > 0) await goTo(row);
      if (app.summary.leftOut > 0) {
        app.say(`The list holds the first ${count(app.summary.frames)} frames; the diagnosis has all`);
      }
      byId("frames").focus({ preventScroll: true });
    },
  };
}
