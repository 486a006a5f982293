// Builds the page: a single file that needs no others, and a folder that can be installed and then works off line.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { reports } from "./reports.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
const ICON =
  "data:image/svg+xml,%3Csvg xmlns='http:%2F%2Fwww.w3.org/2000/svg' viewBox='0 0 16 16'%3E%3Cg fill='none' stroke='%232f6fd6' " +
  "stroke-width='2' stroke-linecap='round'%3E%3Ccircle cx='6.5' cy='6.5' r='4.5'/%3E%3Cpath d='M10 10l4.5 4.5'/%3E%3C/g%3E%3C/svg%3E";

const ASSETS = join(here, "../../reports/assets/uplot");
/** What draws the plots stands with the reports, which need it as a script. */
const UPLOT = {
  name: "uplot",
  setup(build) {
    build.onResolve({ filter: /^uplot$/ }, () => ({ path: join(ASSETS, "uPlot.iife.min.js"), namespace: "uplot" }));
    build.onLoad({ filter: /.*/, namespace: "uplot" }, ({ path }) => ({ contents: `${readFileSync(path, "utf8")}\nexport default uPlot;` }));
  },
};

/** A script with all that it imports. Nothing in it can end the element that it stands in. */
async function bundle(entry) {
  const built = await build({
    entryPoints: [join(here, "src", entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    define: { "import.meta.url": '""' },
    alias: { "canvass-wasm": join(process.cwd(), out, "wasm/canvass_web.js") },
    plugins: [UPLOT],
    legalComments: "inline",
    logLevel: "warning",
  });
  return built.outputFiles[0].text.trim().replaceAll("</", "<\\/").replaceAll("<!--", "<\\!--");
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** Nothing is loaded, sent or run but what stands in the page, and in the reports that it shows. */
function policy(script, style, allowed, more) {
  const scripts = [...new Set([hash(script), ...allowed.scripts])].join(" ");
  const styles = [...new Set([hash(style), ...allowed.styles])].join(" ");
  return [
    "default-src 'none'",
    "connect-src 'none'",
    `script-src ${scripts} 'wasm-unsafe-eval'`,
    `style-src ${styles}`,
    "worker-src blob:" + more.worker,
    "frame-src blob:",
    "img-src data: blob:",
    "base-uri 'none'",
    "form-action 'none'",
    ...more.others,
  ].join("; ");
}

/** One of the pictures that phones and desktops show of an installed page: not all of them take SVG. It stands in the manifest
 * itself, as the page's policy lets no picture be loaded. */
function picture(size) {
  const base64 = readFileSync(join(here, `src/icon-${size}.png`)).toString("base64");
  return { src: `data:image/png;base64,${base64}`, sizes: `${size}x${size}`, type: "image/png", purpose: "any maskable" };
}

const REGISTER = 'window.canvassRegister=()=>navigator.serviceWorker?.register("sw.js").catch(()=>{});';
const MANIFEST = {
  name: "canvass: CANopen captures",
  short_name: "canvass",
  start_url: "./index.html",
  display: "standalone",
  background_color: "#16181c",
  theme_color: "#1f5fc4",
  icons: [{ src: ICON, sizes: "any", type: "image/svg+xml" }, ...[192, 512].map(picture)],
};

const [main, worker] = await Promise.all([bundle("main.js"), bundle("worker.js")]);
const style = readFileSync(join(here, "src/style.css"), "utf8") + readFileSync(join(ASSETS, "uPlot.min.css"), "utf8");
// Compressed where the module was made.
const packed = readFileSync(join(out, "wasm/canvass_web.wasm.gz"));
const template = readFileSync(join(here, "src/index.html"), "utf8");
const allowed = await reports(join(process.cwd(), out, "wasm"));

function page(script, manifest, more) {
  const parts = {
    POLICY: policy(script, style, allowed, more).replaceAll('"', "&quot;"),
    ICON,
    MANIFEST: manifest,
    STYLE: style,
    WORKER: worker,
    WASM: packed.toString("base64"),
    SCRIPT: script,
  };
  return template.replace(/\b(POLICY|ICON|MANIFEST|STYLE|WORKER|WASM|SCRIPT)\b/g, (name) => parts[name]);
}

writeFileSync(join(out, "canvass.html"), page(main, "", { worker: "", others: [] }));

const folder = join(out, "folder");
mkdirSync(folder, { recursive: true });
const own = { worker: " 'self'", others: ["manifest-src 'self'"] };
const index = page(REGISTER + main, '<link rel="manifest" href="manifest.webmanifest">', own);
writeFileSync(join(folder, "index.html"), index);
writeFileSync(join(folder, "manifest.webmanifest"), JSON.stringify(MANIFEST));
const version = createHash("sha256").update(index).digest("hex").slice(0, 16);
writeFileSync(join(folder, "sw.js"), readFileSync(join(here, "src/sw.js"), "utf8").replace("VERSION", version));
console.log(`${join(out, "canvass.html")}: ${(Buffer.byteLength(index) / 1e6).toFixed(1)} MB; wasm.gz ${packed.length} bytes`);
