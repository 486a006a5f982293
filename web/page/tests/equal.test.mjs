// The page gives the same bytes as the program, for every sample.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { load } from "../reports.mjs";

const root = resolve(dirname(fileURLToPath(import.meta.url)), "../../..");
const program = resolve(root, process.env.CANVASS ?? "target/debug/canvass");
const samples = join(root, "traces/samples");
const described = join(root, "conformance/device/models/kuebler-sendix-58x8.eds");
const DATE = 1_750_000_000;
const SURROUNDINGS = { date: "2025-06-15T15:06:40+00:00", zone: "UTC" };
/** What the program is asked for, and what the page is. */
const PRINTED = [
  [["decode", "--format", "text"], { what: "decode", format: "text" }],
  [["decode", "--format", "table"], { what: "decode", format: "table" }],
  [["decode", "--format", "json"], { what: "decode", format: "json" }],
  [["decode", "--format", "csv"], { what: "decode", format: "csv" }],
  [["decode", "--events", "--format", "text"], { what: "events", format: "text" }],
  [["decode", "--events", "--format", "json"], { what: "events", format: "json" }],
  [["decode", "--filter", "service=sdo or node=5", "--format", "json"], { what: "decode", format: "json", filter: "service=sdo or node=5" }],
  [["signals", "--format", "csv"], { what: "signals", format: "csv" }],
  [["signals", "--format", "json"], { what: "signals", format: "json" }],
  [["signals", "--format", "csv", "--every", "10ms"], { what: "signals", format: "csv", every: 10_000_000 }],
];
const FORMS = ["table", "json", "markdown", "junit", "html"];

const files = [];
const { Page } = await load(join(root, "target/page/wasm"), files);

/** What the program prints; where it stands it reads files by their names. */
function printed(folder, args) {
  const env = { ...process.env, SOURCE_DATE_EPOCH: String(DATE), NO_COLOR: "1" };
  const ended = spawnSync(program, args, { cwd: folder, env, maxBuffer: 1 << 30 });
  assert.ok(ended.status !== null && ended.status < 3, `${args.join(" ")}: ${ended.stderr}`);
  return ended.stdout;
}

/** A page with those files. */
function page(folder, names, surroundings, description) {
  const made = new Page(JSON.stringify({ ...SURROUNDINGS, ...surroundings }));
  if (description) made.addDescription(description.name, description.nodes, readFileSync(join(folder, description.name)));
  names.forEach((name, n) => {
    files[n] = readFileSync(join(folder, name));
    made.addCapture(n, name, files[n].length);
  });
  return made;
}

function exported(made, wish) {
  made.export(JSON.stringify(wish));
  const parts = [];
  for (let part; (part = made.exportOn(7)) !== undefined; ) parts.push(part);
  return Buffer.concat(parts);
}

function equal(folder, names, description) {
  const device = description ? ["--device", `${description.nodes}=${description.name}`] : [];
  for (const [args, wish] of PRINTED) {
    const made = page(folder, names, {}, description);
    const [ours, theirs] = [exported(made, wish).toString("latin1"), printed(folder, [...args, ...device, ...names]).toString("latin1")];
    assert.equal(ours, theirs, `${names} ${args}`);
    made.free();
  }
  const diagnose = (form) => printed(folder, ["diagnose", "--format", form, ...device, ...names]);
  const { host } = JSON.parse(diagnose("json")).provenance;
  const made = page(folder, names, { host: host.name, system: host.system }, description);
  made.open();
  while (JSON.parse(made.openOn(11)).more);
  for (const form of FORMS) {
    const ours = Buffer.from(made.diagnosis(form)).toString("latin1");
    assert.equal(ours, diagnose(form).toString("latin1"), `${names} ${form}`);
  }
  made.free();
}

const names = readdirSync(samples).filter((name) => !/\.(frames|py|md)$/.test(name));

for (const name of names) test(`${name}: the same bytes`, () => equal(samples, [name]));

test("several captures, compressed ones, and a description: the same bytes", () => {
  const folder = mkdtempSync(join(tmpdir(), "canvass-web-"));
  const log = readFileSync(join(samples, "python-can.log"));
  writeFileSync(join(folder, "a.log.gz"), gzipSync(log));
  writeFileSync(join(folder, "b.log"), log);
  execFileSync(program, ["convert", "b.log", "c.log.zst"], { cwd: folder });
  writeFileSync(join(folder, "x.eds"), readFileSync(described));
  equal(folder, ["a.log.gz"]);
  equal(folder, ["c.log.zst"]);
  equal(folder, ["a.log.gz", "b.log"]);
  equal(folder, ["b.log"], { name: "x.eds", nodes: "all" });
});

test("a capture that is cut and changed: the same bytes", () => {
  const folder = mkdtempSync(join(tmpdir(), "canvass-web-"));
  for (const name of ["python-can.blf", "three-sections.pcapng", "ros2-lz4.mcap", "ros2-zstd.mcap", "python-can.asc"]) {
    const whole = readFileSync(join(samples, name));
    writeFileSync(join(folder, `cut-${name}`), whole.subarray(0, Math.floor(whole.length * 0.7)));
    const changed = Buffer.from(whole);
    changed[Math.floor(whole.length * 0.6)] ^= 0x55;
    writeFileSync(join(folder, `changed-${name}`), changed);
    equal(folder, [`cut-${name}`]);
    equal(folder, [`changed-${name}`]);
  }
});

/** A page on the computer on which the program runs. */
function here(folder) {
  const { host } = JSON.parse(printed(folder, ["diagnose", "--format", "json", join(samples, "python-can.log")])).provenance;
  return new Page(JSON.stringify({ ...SURROUNDINGS, host: host.name, system: host.system }));
}

const text = (bytes) => Buffer.from(bytes).toString("latin1");

test("devices tried, and results compared: the same bytes", () => {
  const folder = mkdtempSync(join(tmpdir(), "canvass-web-"));
  const made = here(folder);
  const runs = [["1.0", "sim:reference-301", "301/boot-up", false], ["1.1", "sim:reference-301+boot-up-twice", "301/boot-up,301/nmt", true], ["1.2", "sim:reference-301", "301/nmt", false]];
  for (const [release, bus, select, allow] of runs) {
    const args = ["test", bus, "--select", select, ...(allow ? ["--allow", "all"] : []), "--format"];
    made.test(JSON.stringify({ bus, select, allow }));
    assert.equal(text(made.triedPage()), text(printed(folder, [...args, "html"])), `${bus} html`);
    const json = printed(folder, [...args, "json"]);
    assert.equal(text(made.triedJson()), text(json), `${bus} json`);
    writeFileSync(join(folder, `${release}.json`), json);
  }
  const fuzz = { bus: "sim:reference-301+boot-up-twice", target: "nmt", sequences: 20, seed: 3 };
  made.fuzz(JSON.stringify(fuzz));
  const fuzzed = ["fuzz", fuzz.bus, "--target", fuzz.target, "--runs", String(fuzz.sequences), "--seed", String(fuzz.seed), "--format"];
  assert.equal(text(made.triedPage()), text(printed(folder, [...fuzzed, "html"])), "fuzz html");
  assert.equal(text(made.triedJson()), text(printed(folder, [...fuzzed, "json"])), "fuzz json");
  const add = (name) => made.addResult(name, readFileSync(join(folder, name)));
  const names = runs.map(([release]) => `${release}.json`);
  names.slice(0, 2).forEach(add);
  assert.equal(text(made.compare()), text(printed(folder, ["compare", "--format", "html", ...names.slice(0, 2)])));
  names.forEach(add);
  assert.equal(text(made.history()), text(printed(folder, ["history", "--format", "html", ...names])));
  made.free();
});
