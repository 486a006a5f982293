import { element, frame, save } from "../dom.js";

const WELCOME = [
  "Drop captures of a CANopen network here, and device descriptions (EDS, DCF, XDD) with them.",
  "Candump logs, Vector ASC and BLF, PEAK TRC, pcap and pcapng, MCAP, CSV of python-can, CANopen Minimonitor; compressed by gzip or zstd too.",
  "All work is done in this page. It sends nothing and loads nothing: its content security policy forbids it.",
];
const FORMS = [["json", "json"], ["markdown", "md"], ["junit", "xml"], ["table", "txt"]];

/** The page that `canvass diagnose --format html` writes. */
export function diagnosisView(app, root) {
  let shown = null;
  let html = null;

  async function fill() {
    html = await app.engine.call("diagnosis", { form: "html" });
    const buttons = FORMS.map(([form, ending]) =>
      element("button", { type: "button", class: "plain", onclick: () => download(form, ending) }, form),
    );
    const page = element("button", { type: "button", class: "plain", onclick: () => save("diagnosis.html", html, "text/html") }, "html");
    const bar = element("div", { class: "bar" }, element("span", {}, "Save as "), page, buttons);
    root.replaceChildren(...[bar, damage(app.summary), frame("Diagnosis", html)].filter(Boolean));
  }

  async function download(form, ending) {
    save(`diagnosis.${ending}`, await app.engine.call("diagnosis", { form }));
  }

  return {
    refresh() {
      shown = html = null;
      const lines = WELCOME.map((line) => element("p", {}, line));
      root.replaceChildren(element("div", { class: "welcome" }, app.captures.length > 0 ? [] : lines));
    },
    shown() {
      if (!app.summary || shown === app.summary) return;
      shown = app.summary;
      fill();
    },
  };
}

/** What could not be read. */
function damage({ damage, damages }) {
  if (damage.length === 0) return null;
  const lines = damage.map((line) => element("li", {}, line));
  return element("details", { class: "damage" }, element("summary", {}, `${damages} places can't be read`), element("ul", {}, lines));
}
