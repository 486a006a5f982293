import { start } from "./engine.js";
import { byId, count, counted, element, setColours } from "./dom.js";
import * as state from "./state.js";
import { diagnosisView } from "./views/diagnosis.js";
import { traceView } from "./views/trace.js";
import { edsView } from "./views/eds.js";
import { exportView } from "./views/export.js";
import { resultsView } from "./views/results.js";
import { signalsView } from "./views/signals.js";
import { trialView } from "./views/trial.js";

/** The state that the views share. */
const app = {
  engine: null,
  captures: [],
  /** The summary of the captures; null while none is open. */
  summary: null,
  /** Descriptions: name, nodes, bytes, and summary. */
  described: [],
  /** Results of test, fuzz and compare: names and bytes. */
  results: [],
  /** Options for reading: the id of the format (null: recognised), and whether equal channel names are one bus. */
  options: { format: null, same_bus: false },
  /** The time of the cursor in all views, in seconds since the first frame. */
  cursor: null,
  state,
  say,
  run,
  reopen,
  describe,
  show,
  point,
  addResults,
};

const VIEWS = [
  ["diagnosis", "Diagnosis", diagnosisView],
  ["trace", "Trace", traceView],
  ["signals", "Signals", signalsView],
  ["eds", "EDS", edsView],
  ["results", "Results", resultsView],
  ["try", "Try it", trialView],
  ["export", "Export", exportView],
];
const views = new Map();
/** The names of files that describe devices. */
const DESCRIPTION = /\.(eds|dcf|xdd|xdc)$/i;

/** Number of times that captures were opened or closed. */
let openings = 0;

function say(text, bad = false) {
  const status = byId("status");
  status.textContent = text;
  status.classList.toggle("bad", bad);
}

/** Runs a long call and shows its progress; returns nothing if it was cancelled or failed. */
async function run(kind, what, args, text) {
  const box = byId("progress");
  const [bar, label, cancel] = box.children;
  box.hidden = false;
  bar.removeAttribute("value");
  label.textContent = text;
  cancel.onclick = () => app.engine.call("cancel", { kind });
  try {
    const result = await app.engine.call(what, args, (at) => {
      if (at.size) bar.value = at.read / at.size;
      else if (at.done !== undefined) bar.value = at.done / Math.max(1, at.all);
      else if (at.all) bar.value = at.looked / at.all;
      label.textContent = at.frames === undefined ? text : `${text}: ${count(at.frames)} frames`;
    });
    if (result?.cancelled) {
      say(`${text}: cancelled`);
      return null;
    }
    return result;
  } catch (error) {
    say(error.message, true);
    return null;
  } finally {
    box.hidden = true;
  }
}

const bytesOf = async (file) => new Uint8Array(await file.arrayBuffer());

/** Whether a file describes a device, by its name or by how it begins. */
async function isDescription(file) {
  if (DESCRIPTION.test(file.name)) return true;
  const head = await file.slice(0, 4096).text();
  return /^\uFEFF?\s*(;.*\s*)*\[(FileInfo|DeviceInfo)\]/i.test(head) || /<ISO15745Profile/.test(head);
}

/** Whether the files are pieces of one recording: their names differ in numbers only. */
const arePieces = (files) => files.length > 1 && new Set(files.map(({ name }) => name.replace(/\d+/g, "#"))).size === 1;

/** Opens files that the user dropped or chose. */
async function take(files) {
  const [captures, results] = [[], []];
  let described = 0;
  for (const file of files) {
    if (/\.json$/i.test(file.name)) results.push([file.name, await bytesOf(file)]);
    else if (await isDescription(file)) described += await describe(file.name, "", await bytesOf(file));
    else captures.push(file);
  }
  if (results.length > 0) {
    addResults(results);
    if (captures.length === 0) return show("results");
  }
  if (captures.length > 0) await replace(captures);
  else if (app.captures.length > 0 && described > 0) await reopen();
  else show(app.described.length > 0 ? "eds" : undefined);
}

/** Opens other captures; those that are open stay open if they can't be read. */
async function replace(captures) {
  const { captures: before, options } = app;
  app.captures = captures;
  app.options = { ...options, same_bus: arePieces(captures) };
  byId("same-bus").checked = app.options.same_bus;
  if ((await reopen()) !== false || before.length === 0) return;
  const why = byId("status").textContent;
  Object.assign(app, { captures: before, options });
  byId("same-bus").checked = options.same_bus;
  await reopen();
  say(`${captures.map(({ name }) => name).join(", ")}: ${why}; the captures before are open again`, true);
}

/** Adds results, which replace those with the same names. */
function addResults(results) {
  app.results = [...app.results.filter(([name]) => !results.some(([other]) => other === name)), ...results];
  views.get("results").refresh();
}

/** Adds a description for these nodes, or changes its nodes; returns whether it could be used. */
async function describe(name, nodes, bytes) {
  // Two descriptions can't both be that of all nodes.
  const other = app.described.find((known) => known.name !== name && known.nodes === "all");
  if (nodes === "" && other) {
    say(`${name}: ${other.name} describes all nodes already; name the nodes of one of them under EDS first`, true);
    return false;
  }
  try {
    const known = await app.engine.call("describe", { name, nodes, bytes });
    app.described = [...app.described.filter((other) => other.name !== name), { ...known, bytes }];
    say(`${name}: ${counted(known.objects, "object")}, of node ${known.nodes}`);
    views.get("eds").refresh();
    return true;
  } catch (error) {
    say(error.message, true);
    return false;
  }
}

/** Reads the captures from their beginning; returns `false` if they can't be read. */
async function reopen() {
  if (app.captures.length === 0) return;
  app.summary = app.cursor = null;
  opened();
  refresh();
  performance.mark("canvass-open");
  const opening = ++openings;
  const summary = await run("open", "open", { captures: app.captures, options: app.options }, "Reading");
  // Other files were opened meanwhile, or the same with other options.
  if (opening !== openings) return;
  if (!summary) {
    close(false);
    return false;
  }
  performance.measure("canvass-read", "canvass-open");
  app.summary = summary;
  const { errors, warnings, damages } = summary;
  const unread = damages > 0 ? `, ${counted(damages, "place")} that can't be read` : "";
  say(`${summary.formats.join(", ")}: ${counted(summary.frames, "frame")}, ${counted(errors, "error")}, ${counted(warnings, "warning")}${unread}`);
  refresh();
}

/** Closes the captures. */
function close(quietly = true) {
  openings++;
  app.captures = [];
  app.summary = app.cursor = null;
  app.engine.call("close");
  opened();
  if (quietly) say("");
  refresh();
}

/** Shows which captures are open, and how they are read. */
function opened() {
  const { length } = app.captures;
  byId("names").textContent = app.captures.map((file) => file.name).join(", ");
  byId("again").hidden = byId("reading").hidden = length === 0;
  byId("same-bus").closest("label").hidden = length < 2;
}

function reading() {
  const format = byId("format");
  format.append(...app.engine.formats.map(({ id, name }) => element("option", { value: id }, name)));
  format.addEventListener("change", () => {
    app.options = { ...app.options, format: format.value || null };
    reopen();
  });
  byId("same-bus").addEventListener("change", ({ target }) => {
    app.options = { ...app.options, same_bus: target.checked };
    reopen();
  });
}

/** Refreshes the views after other captures were opened. */
function refresh() {
  views.forEach((view) => view.refresh?.());
  show(state.get("view"));
}

/** Shows a view. */
function show(wanted) {
  const id = VIEWS.some(([id]) => id === wanted) ? wanted : "diagnosis";
  // The browser's button Back leads to the view before, not away from the captures.
  state.set({ view: id }, { isStep: (state.get("view") ?? "diagnosis") !== id });
  for (const [other] of VIEWS) {
    const tab = byId(`tab-${other}`);
    tab.setAttribute("aria-selected", other === id);
    tab.tabIndex = other === id ? 0 : -1;
    byId(`view-${other}`).hidden = other !== id;
  }
  byId(`tab-${id}`).scrollIntoView({ block: "nearest", inline: "nearest" });
  views.get(id).shown?.();
}

/** Moves the cursor of all other views to the time at which one view points. */
function point(seconds, from) {
  app.cursor = seconds;
  views.forEach((view) => view !== from && view.point?.(seconds));
}

function tabs() {
  const bar = byId("tabs");
  for (const [id, name, make] of VIEWS) {
    const tab = element("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `view-${id}`, onclick: () => show(id) }, name);
    bar.append(tab);
    const root = element("section", { id: `view-${id}`, role: "tabpanel", "aria-labelledby": `tab-${id}`, hidden: true });
    byId("main").append(root);
    views.set(id, make(app, root));
  }
  bar.addEventListener("keydown", (event) => {
    const all = [...bar.children];
    const at = all.indexOf(document.activeElement);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: -1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const next = all.at(to % all.length);
    next.focus();
    next.click();
  });
}

function drops() {
  const { body } = document;
  body.addEventListener("dragover", (event) => {
    event.preventDefault();
    body.classList.add("over");
  });
  body.addEventListener("dragleave", () => body.classList.remove("over"));
  body.addEventListener("drop", (event) => {
    event.preventDefault();
    body.classList.remove("over");
    take([...event.dataTransfer.files]);
  });
  body.addEventListener("paste", pasted);
  byId("files").addEventListener("change", ({ target }) => {
    take([...target.files]);
    target.value = "";
  });
  byId("again").addEventListener("click", () => close());
}

/** Opens what the user pastes: files, or the text of frames. A field takes its own text. */
function pasted(event) {
  if (event.target.closest("input, select, textarea")) return;
  const { files } = event.clipboardData;
  const text = event.clipboardData.getData("text/plain");
  if (files.length === 0 && text.trim() === "") return;
  event.preventDefault();
  take(files.length > 0 ? [...files] : [new File([text], "pasted.txt", { type: "text/plain" })]);
}

function theme() {
  const choice = byId("theme");
  choice.value = state.get("theme") ?? "";
  choice.addEventListener("change", () => {
    state.set({ theme: choice.value });
    setColours(choice.value);
    views.forEach((view) => view.painted?.());
  });
  setColours(choice.value);
}

/** Lets a second worker hash the files that the engine reads. */
function hashBy(hasher) {
  const { port1, port2 } = new MessageChannel();
  hasher.call("hashFor", { port: port1 }, undefined, [port1]);
  app.engine.call("hashBy", { port: port2 }, undefined, [port2]);
  // All workers share the compiled code.
  hasher.call("warm").then(() => performance.mark("canvass-warm"), () => {});
}

async function begin() {
  theme();
  tabs();
  try {
    app.engine = await start((why) => say(`The decoder has stopped, please reload the page: ${why}`, true));
  } catch (error) {
    return say(`This browser can't run the decoder, it needs one of 2023 or later: ${error.message}`, true);
  }
  reading();
  drops();
  // Without this worker the engine computes the hashes itself.
  app.engine.sibling(() => app.engine.call("hashBy")).then(hashBy, () => {});
  window.addEventListener("popstate", () => show(state.get("view")));
  // A page that is left loses its captures.
  window.addEventListener("beforeunload", (event) => app.captures.length > 0 && event.preventDefault());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => views.forEach((view) => view.painted?.()));
  refresh();
  if (window.canvassRegister) window.canvassRegister();
  document.documentElement.dataset.ready = "yes";
}

begin();
