// The worker does all work off the page's thread. It reads the captures from the user's files, a piece at a time.
import { initSync, Page } from "canvass-wasm";
import * as files from "./files.js";
import { hashFor } from "./hashing.js";
import { warm } from "./warm.js";

globalThis.canvassHost = {
  read: files.read,
  progress(done, all, what) {
    if (performance.now() - shown < 50) return;
    shown = performance.now();
    postMessage({ id: current, progress: { done, all, what } });
  },
  now: () => performance.now(),
  stopped(why) {
    postMessage({ stopped: why });
  },
};

let page;
/** The number of the current call, and the time of its last progress message. */
let current = 0;
let shown = 0;
/** The latest job of each kind; earlier ones are cancelled. */
const latest = new Map();
/** The choice of captures that is being opened; null if there is none. */
let reading = null;

/** Lets messages be handled between steps. Several jobs can wait for this. */
const channel = new MessageChannel();
const breathing = [];
channel.port1.onmessage = () => breathing.shift()();
function breathe() {
  return new Promise((resolve) => {
    breathing.push(resolve);
    channel.port2.postMessage(0);
  });
}

/** Calls `step` until there is no more work, or another job of the kind begins; waits for `ready` before each step. */
async function job(kind, step, tell, ready = () => {}) {
  const own = Symbol(kind);
  latest.set(kind, own);
  let told = performance.now();
  for (;;) {
    const state = step();
    if (!state.more) return state;
    if (performance.now() - told > 100) {
      told = performance.now();
      tell(state);
    }
    const gone = () => latest.get(kind) !== own;
    await breathe();
    // A job that another one has replaced does not wait for the files of the new one.
    if (!gone()) await ready();
    if (gone()) return { ...state, cancelled: true };
  }
}

/** Number of frames between two checks for messages: about 20 ms of work. */
const STEP = 20_000;

/** The index of the list, as a promise, and the functions that receive its progress. */
let indexed = null;
const watching = new Set();

/** Makes the index of the list, once. */
function index(tell) {
  watching.add(tell);
  if (indexed) return indexed;
  const began = job("index", () => JSON.parse(page.indexOn(STEP)), (state) => watching.forEach((told) => told(state)));
  indexed = began.then((end) => {
    watching.clear();
    return end;
  });
  return indexed;
}

/** Adds results to the page for a comparison: their names and bytes. */
function added(results) {
  results.forEach(([name, bytes]) => page.addResult(name, bytes));
  return page;
}

/** Reads the captures of this choice; returns their summary. */
async function opened(choice, captures, options, tell) {
  captures.forEach((file, number) => page.addCapture(number, file.name, file.size));
  page.options(JSON.stringify(options));
  await files.ready();
  if (files.gone(choice)) return { cancelled: true };
  const hashed = files.areHashed();
  page.open(hashed);
  const end = await job("open", () => JSON.parse(page.openOn(STEP)), tell, files.ready);
  if (end.cancelled) return { cancelled: true };
  const hashes = await files.hashes();
  if (files.gone(choice)) return { cancelled: true };
  if (hashed) page.hashed(JSON.stringify(hashes ?? captures.map(() => null)));
  return JSON.parse(page.summary());
}

const calls = {
  start({ module, surroundings }) {
    initSync({ module });
    page = new Page(JSON.stringify(surroundings));
    return { formats: JSON.parse(Page.formats()) };
  },
  /** The worker at this port hashes the files that this worker reads; without a port, this worker does. */
  hashBy: ({ port }) => files.hashBy(port ?? null),
  /** Hashes the files that the worker at the other end of this port reads. */
  hashFor: ({ port }) => hashFor(port, () => latest.delete("warm")),
  /** Warms up until other work arrives. */
  warm: () => job("warm", warm(), () => {}),
  async open({ captures, options }, tell) {
    calls.close();
    const choice = (reading = files.choose(captures));
    try {
      return await opened(choice, captures, options, tell);
    } finally {
      if (reading === choice) reading = null;
    }
  },
  /** Closes the captures, and cancels all jobs about them. */
  close() {
    latest.clear();
    indexed = null;
    files.choose([]);
    page.close();
  },
  cancel({ kind }) {
    latest.delete(kind);
    // The decoder may be waiting for its files.
    if (kind === "open" && reading !== null) files.choose([]);
    // A repeated request continues where the index was.
    if (kind === "index") indexed = null;
  },
  describe: ({ name, nodes, bytes }) => JSON.parse(page.addDescription(name, nodes, bytes)),
  forget: ({ name }) => page.removeDescription(name),
  diagnosis: ({ form }) => page.diagnosis(form),
  descriptionPage: ({ name }) => page.descriptionPage(name),
  descriptionFindings: ({ name }) => JSON.parse(page.descriptionFindings(name)),
  rows: ({ from, count }) => JSON.parse(page.rows(from, count)),
  details: ({ row }) => JSON.parse(page.details(row)),
  index: (_, tell) => index(tell),
  overview: () => JSON.parse(page.overview()),
  completions: ({ text }) => JSON.parse(page.completions(text)),
  checkFilter: ({ text }) => JSON.parse(Page.checkFilter(text)),
  async choose({ filter, text }, tell) {
    page.choose(filter, text);
    return job("choose", () => JSON.parse(page.chooseOn(STEP)), tell);
  },
  rank: ({ row }) => page.rank(row),
  rowAt: ({ seconds }) => page.rowAt(seconds),
  async find({ filter, text, from, backwards }, tell) {
    page.find(filter, text, from, backwards);
    return job("find", () => JSON.parse(page.findOn(STEP)), tell);
  },
  async plots(_, tell) {
    page.plots();
    return job("plots", () => JSON.parse(page.plotsOn(STEP)), tell);
  },
  points: ({ column, from, to, parts }) => page.points(column, from, to, parts),
  choices: () => JSON.parse(Page.choices()),
  /** Runs a trial to its end without a break; to cancel it, this worker is ended. */
  trial({ kind, wish }) {
    page[kind](JSON.stringify(wish));
    return { html: page.triedPage(), json: page.triedJson() };
  },
  compare: ({ results }) => added(results).compare(),
  history: ({ results }) => added(results).history(),
  async export({ wish }, tell) {
    page.export(JSON.stringify(wish));
    const parts = [];
    const step = () => {
      const piece = page.exportOn(STEP);
      if (piece === undefined) return { more: false };
      // A blob is kept outside the memory of the worker.
      if (piece.length > 0) parts.push(new Blob([piece]));
      return { ...JSON.parse(page.exportProgress()), more: true };
    };
    const end = await job("export", step, tell);
    return end.cancelled ? { cancelled: true } : { blob: new Blob(parts) };
  },
};

onmessage = async ({ data: { id, call, args } }) => {
  const tell = (progress) => postMessage({ id, progress });
  current = id;
  try {
    const result = await calls[call](args, tell);
    postMessage({ id, result });
  } catch (error) {
    postMessage({ id, error: String(error?.message ?? error) });
  }
};
