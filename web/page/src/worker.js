// All work is done here, off the page's thread: the captures are read where they lie, a piece at a time.
import { initSync, Page } from "canvass-wasm";

const files = new Map();
const reader = new FileReaderSync();
/** What is read of a file at once. */
const PIECE = 4 << 20;

/** Takes the piece of a file from `at` on, and has the one after it fetched while this one is worked on. */
function turn(known, at) {
  const { ahead } = known;
  known.from = at;
  known.piece = ahead?.from === at && ahead.piece ? ahead.piece : new Uint8Array(reader.readAsArrayBuffer(known.file.slice(at, at + PIECE)));
  const next = { from: at + known.piece.length, piece: null };
  known.ahead = next;
  if (next.from >= known.file.size) return;
  const came = (bytes) => (next.piece = new Uint8Array(bytes));
  // Who needs it finds out that it can't be read.
  known.file.slice(next.from, next.from + PIECE).arrayBuffer().then(came, () => {});
}

/** Files up to this length are read once more for their hash, by the browser's own code and beside the decoding. */
const HASHED_AT_ONCE = 64 << 20;

/** The SHA-256 of a file, in hexadecimal; nothing where the browser does not work it out. */
async function hashed(file) {
  const digest = await crypto.subtle.digest("SHA-256", await file.arrayBuffer());
  return Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

globalThis.canvassHost = {
  read(number, at, buffer) {
    const known = files.get(number);
    if (!known.piece || at < known.from || at >= known.from + known.piece.length) turn(known, at);
    const begin = at - known.from;
    const part = known.piece.subarray(begin, begin + buffer.length);
    buffer.set(part);
    return part.length;
  },
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
/** The captures that are open or being opened. */
let open = null;
/** The call under way, and when its progress was told. */
let current = 0;
let shown = 0;
/** Only the latest of each kind of job goes on. */
const latest = new Map();

/** Lets messages in. Several jobs can wait for their turn. */
const channel = new MessageChannel();
const breathing = [];
channel.port1.onmessage = () => breathing.shift()();
function breathe() {
  return new Promise((resolve) => {
    breathing.push(resolve);
    channel.port2.postMessage(0);
  });
}

/** Calls `step` until it says that there is no more, or another job of the kind begins. */
async function job(kind, step, tell) {
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
    await breathe();
    if (latest.get(kind) !== own) return { ...state, cancelled: true };
  }
}

/** Frames between two looks at the messages: about 20 ms of work. */
const STEP = 20_000;

/** Frames of every common kind, which stand for a capture. */
const USUAL = ["000#0105", "080#", "181#0102030405060708", "281#1122", "081#1050010000000000", "601#4018100100000000", "581#4318100113000000", "601#2B17100064000000", "581#6017100000000000", "701#05"];
const USUAL_FRAMES = 30_000;

/** Decodes what nobody has asked for: browsers compile a program while it runs, so the first capture would pay for that. It ends
 * at once when there is something to do. */
async function warmUp(surroundings) {
  const line = (_, n) => `(${(1_700_000_000 + n / 2000).toFixed(6)}) can0 ${USUAL[n % USUAL.length]}\n`;
  const file = new Blob([Array.from({ length: USUAL_FRAMES }, line).join("")]);
  const number = 0xffff_ffff;
  const usual = new Page(JSON.stringify(surroundings));
  files.set(number, { file });
  usual.addCapture(number, "usual.log", file.size);
  usual.open();
  const end = await job("warm-up", () => JSON.parse(usual.openOn(STEP / 10)), () => {});
  files.delete(number);
  if (!end.cancelled) {
    usual.diagnosis("html");
    postMessage({ warm: true });
  }
  usual.free();
}

const calls = {
  start({ module, surroundings, warm }) {
    initSync({ module });
    page = new Page(JSON.stringify(surroundings));
    if (warm) setTimeout(() => warmUp(surroundings), 0);
    return { formats: JSON.parse(Page.formats()) };
  },
  async open({ captures, options }, tell) {
    calls.close();
    files.clear();
    open = captures;
    const hashes = captures.map((file, number) => {
      // The function is there on pages from the disk and by https only.
      const isHashed = file.size <= HASHED_AT_ONCE && crypto.subtle !== undefined;
      files.set(number, { file });
      page.addCapture(number, file.name, file.size, isHashed);
      return isHashed ? hashed(file) : null;
    });
    // Who needs one finds out that it can't be had.
    hashes.forEach((hash) => hash?.catch(() => {}));
    page.options(JSON.stringify(options));
    page.open();
    const end = await job("open", () => JSON.parse(page.openOn(STEP)), tell);
    files.forEach((known) => {
      delete known.piece;
      delete known.ahead;
    });
    const known = end.cancelled ? [] : await Promise.all(hashes);
    // They may have been closed meanwhile.
    if (end.cancelled || open !== captures) return { cancelled: true };
    known.forEach((hash, number) => hash && page.sayHash(number, hash));
    return JSON.parse(page.summary());
  },
  /** Whatever is under way is of captures that are gone. */
  close() {
    open = null;
    latest.clear();
    page.close();
  },
  cancel({ kind }) {
    latest.delete(kind);
  },
  describe: ({ name, nodes, bytes }) => JSON.parse(page.addDescription(name, nodes, bytes)),
  forget: ({ name }) => page.removeDescription(name),
  diagnosis: ({ form }) => page.diagnosis(form),
  descriptionPage: ({ name }) => page.descriptionPage(name),
  descriptionFindings: ({ name }) => JSON.parse(page.descriptionFindings(name)),
  rows: ({ from, count }) => JSON.parse(page.rows(from, count)),
  details: ({ row }) => JSON.parse(page.details(row)),
  overview: () => JSON.parse(page.overview()),
  completions: ({ text }) => JSON.parse(page.completions(text)),
  checkFilter: ({ text }) => JSON.parse(Page.checkFilter(text)),
  async choose({ filter, text }, tell) {
    page.choose(filter, text);
    return job("choose", () => JSON.parse(page.chooseOn(STEP)), tell);
  },
  rank: ({ row }) => page.rank(row),
  rowAt: ({ seconds }) => page.rowAt(seconds),
  async find({ text, from, backwards }, tell) {
    page.find(text, from, backwards);
    return job("find", () => JSON.parse(page.findOn(STEP)), tell);
  },
  async plots(_, tell) {
    page.plots();
    return job("plots", () => JSON.parse(page.plotsOn(STEP)), tell);
  },
  points: ({ column, from, to, parts }) => page.points(column, from, to, parts),
  choices: () => JSON.parse(Page.choices()),
  /** Runs to its end at once; who wants it to end before ends this worker. */
  trial({ kind, wish }) {
    page[kind](JSON.stringify(wish));
    return { html: page.triedPage(), json: page.triedJson() };
  },
  compare: ({ results }) => page.compare(JSON.stringify(results)),
  history: ({ results }) => page.history(JSON.stringify(results)),
  async export({ wish }, tell) {
    page.export(JSON.stringify(wish));
    const parts = [];
    const step = () => {
      const piece = page.exportOn(STEP);
      if (piece === undefined) return { more: false };
      // A blob is not held in this memory.
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
