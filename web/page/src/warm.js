// The decoder reads a generated capture before the user chooses one: a browser optimises only code that has run for a
// while, and the user should not wait for that.
import { Page } from "canvass-wasm";
import { lend } from "./files.js";

/** A number that no capture of the user has. */
const NUMBER = 0xffff_ffff;
/** Length of the traffic in seconds. */
const SECONDS = 120;
/** Number of frames in a step: calls that arrive meanwhile wait only for a step. */
const STEP = 5_000;

/** Returns the function for the steps, whose result has `more` false after the last. */
export function warm() {
  let page;
  return () => {
    if (page) return read(page);
    const bytes = new TextEncoder().encode(traffic());
    lend(NUMBER, bytes);
    page = new Page("{}");
    page.addCapture(NUMBER, "traffic.log", bytes.length);
    page.open(true);
    return { more: true };
  };
}

function read(page) {
  const state = JSON.parse(page.openOn(STEP));
  if (!state.more) {
    page.summary();
    page.diagnosis("html");
    page.free();
    lend(NUMBER);
  }
  return state;
}

/** A candump log of usual traffic, with some errors in it. */
function traffic() {
  const lines = [];
  const hex = (number, digits) => number.toString(16).toUpperCase().padStart(digits, "0");
  const turned = (number) => hex(number, 8).match(/../g).reverse().join("");
  const say = (micros, frame) => lines.push(`(${1_700_000_000 + Math.floor(micros / 1e6)}.${String(micros % 1e6).padStart(6, "0")}) can0 ${frame}`);
  ["000#0100", ...[1, 2, 3].map((node) => `70${node}#00`)].forEach((frame, n) => say(n * 1000, frame));
  for (let n = 1; n < SECONDS * 100; n++) {
    const at = n * 10_000;
    say(at, "080#");
    for (const node of [1, 2, 3]) {
      say(at + 200 * node, `18${node}#${turned(n * 37 * node)}${turned(n)}`);
      if (n % 100 === 10 * node) say(at + 1000, `70${node}#05`);
      if (n % 500 === 10 * node) say(at + 1500, `08${node}#${n % 1000 < 500 ? "3081118100000000" : "0000008100000000"}`);
    }
    const [request, answer] = sdo(n, turned);
    say(at + 2000, `601#${request}`);
    say(at + 2600, `581#${answer}`);
  }
  return `${lines.join("\n")}\n`;
}

/** An SDO request and its answer: expedited, segmented, aborted. */
function sdo(n, turned) {
  const transfers = [
    ["4000100000000000", "4300100092010200"],
    ["2B171000E8030000", "6017100000000000"],
    ["4008100000000000", "410810000A000000"],
    ["6000000000000000", "0063616E76617373"],
    ["7000000000000000", "19313233FFFFFFFF"],
    ["4004600000000000", `43046000${turned(n * 11)}`],
    ["4099200000000000", "8099200000000206"],
  ];
  return transfers[n % transfers.length];
}
