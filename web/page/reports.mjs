// Hashes of the scripts and styles of the reports. They are read from reports, so that there is no second list of them.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const LOG = "(1700000000.000000) can0 705#00\n(1700000001.000000) can0 705#05\n";
const EDS = "[FileInfo]\nFileName=x.eds\n[DeviceInfo]\nVendorName=x\n[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n[1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\n";

/** The module, ready to be called; `files` are what it reads. */
export async function load(folder, files) {
  globalThis.canvassHost = {
    read(number, at, buffer) {
      const part = files[number].subarray(at, at + buffer.length);
      buffer.set(part);
      return part.length;
    },
    progress() {},
    now: () => performance.now(),
    stopped: (why) => console.error(why),
  };
  const module = await import(pathToFileURL(join(folder, "canvass_web.js")));
  module.initSync({ module: readFileSync(join(folder, "canvass_web_bg.wasm")) });
  return module;
}

/** All hashes that the policies of reports name. */
export async function reports(folder) {
  const log = Buffer.from(LOG);
  const { Page } = await load(folder, [log]);
  const page = new Page(JSON.stringify({ host: "x", system: "x", date: "2026-01-01T00:00:00Z", zone: "UTC" }));
  page.addCapture(0, "x.log", log.length);
  page.open();
  while (JSON.parse(page.openOn(1000)).more);
  page.addDescription("x.eds", "", Buffer.from(EDS));
  const all = [page.diagnosis("html"), page.descriptionPage("x.eds")];
  const bus = "sim:reference-301";
  page.test(JSON.stringify({ bus, select: "301/boot-up" }));
  all.push(page.triedPage());
  const result = page.triedJson();
  const add = () => page.addResult("x.json", result);
  add(), add(), all.push(page.compare());
  add(), all.push(page.history());
  page.fuzz(JSON.stringify({ bus, target: "nmt", sequences: 1 }));
  all.push(page.triedPage());
  const pages = all.map((bytes) => Buffer.from(bytes).toString());
  const hashes = (name) => pages.flatMap((html) => new RegExp(`${name}-src ([^;]*)`).exec(html)[1].split(" ")).filter((one) => one.startsWith("&#39;sha") || one.startsWith("'sha"));
  return { scripts: hashes("script").map(plain), styles: hashes("style").map(plain) };
}

const plain = (hash) => hash.replaceAll("&#39;", "'");
