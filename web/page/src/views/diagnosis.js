import { button, element, frame, save, welcome } from "../dom.js";

const WELCOME = [
  "Drop captures of a CANopen network here, and device descriptions (EDS, DCF, XDD) with them; or paste frames that another tool shows.",
  "Candump logs, Vector ASC and BLF, MF4, PEAK TRC, pcap and pcapng, MCAP, CSV of python-can, CANopen Minimonitor; compressed by gzip or zstd too. Several captures become one.",
  "All work is done in this page. It sends nothing and loads nothing: its content security policy forbids it.",
];
const FORMS = [["json", "json"], ["markdown", "md"], ["junit", "xml"], ["table", "txt"]];

/** The view of the page that `canvass diagnose --format html` writes. */
export function diagnosisView(app, root) {
  let shown = null;
  let page = null;
  const time = element("span", { class: "shown" });
  const view = { refresh, shown: show, point };

  async function fill(summary) {
    const html = await app.engine.call("diagnosis", { form: "html" });
    // Other captures were opened meanwhile.
    if (summary !== app.summary) return;
    page = frame("Diagnosis", html);
    page.addEventListener("load", () => {
      performance.measure("canvass-diagnosis", "canvass-open");
      // The index is ready when the user goes on to the list.
      app.engine.call("index").catch(() => {});
      if (app.cursor !== null) point(app.cursor);
    });
    const buttons = FORMS.map(([form, ending]) => button(form, () => download(form, ending), { class: "plain" }));
    const bar = element("div", { class: "bar" }, element("span", {}, "Save as "), button("html", () => save("diagnosis.html", html, "text/html"), { class: "plain" }), buttons, time);
    root.replaceChildren(...[bar, damage(summary), page].filter(Boolean));
  }

  async function download(form, ending) {
    save(`diagnosis.${ending}`, await app.engine.call("diagnosis", { form }));
  }

  function refresh() {
    shown = page = null;
    time.replaceChildren();
    const wait = element("div", { class: "welcome" });
    root.replaceChildren(app.captures.length > 0 ? wait : welcome(...WELCOME));
  }

  async function show() {
    if (!app.summary || shown === app.summary) return;
    shown = app.summary;
    await fill(shown);
  }

  /** Moves the cursor in the timeline and the plots of the report to the time of another view. */
  function point(seconds) {
    page?.contentWindow?.postMessage({ cursor: seconds }, "*");
    tell(seconds);
  }

  function tell(seconds) {
    time.replaceChildren(`Cursor at ${seconds.toFixed(6)} s `, button("Show in the trace", () => app.show("trace"), { class: "plain" }));
  }

  // Only messages of the report in our frame are accepted, and only a number in them.
  addEventListener("message", ({ source, data }) => {
    const seconds = data?.cursor;
    if (!page || source !== page.contentWindow || !Number.isFinite(seconds)) return;
    app.point(seconds, view);
    tell(seconds);
  });

  return view;
}

/** The damage in the captures. */
function damage({ damage, damages }) {
  if (damage.length === 0) return null;
  const lines = damage.map((line) => element("li", {}, line));
  return element("details", { class: "damage" }, element("summary", {}, `${damages} places can't be read`), element("ul", {}, lines));
}
