import { button, counted, element, save, welcome } from "../dom.js";
import { suggest } from "../suggest.js";

const PRINTED = [
  ["decode", "text", "Decoded frames as text", "txt"],
  ["decode", "table", "Decoded frames as a table", "txt"],
  ["decode", "csv", "Decoded frames as CSV", "csv"],
  ["decode", "json", "Decoded frames as JSON Lines", "jsonl"],
  ["events", "text", "Events as text", "txt"],
  ["events", "json", "Events as JSON Lines", "jsonl"],
  ["signals", "csv", "Values of PDOs as CSV", "csv"],
  ["signals", "json", "Values of PDOs as JSON Lines", "jsonl"],
];
const ENDINGS = { candump: "log", "python-can-csv": "csv" };

/** The view for downloads of the outputs that the program has for captures. */
export function exportView(app, root) {
  function fill() {
    if (!app.summary) {
      root.replaceChildren(welcome("Open a capture first."));
      return;
    }
    const filter = element("input", { type: "text", value: app.state.get("filter") ?? "", placeholder: "all frames", "aria-label": "Filter of the export" });
    const gzip = element("input", { type: "checkbox" });
    const printed = PRINTED.map(([what, format, name, ending]) => button(name, () => write({ what, format, filter: filter.value }, ending)));
    const written = app.engine.formats.filter((format) => format.written).map(({ id, name }) => {
      const ending = () => (ENDINGS[id] ?? id) + (gzip.checked ? ".gz" : "");
      return button(name, () => write({ what: "convert", format: id, filter: filter.value, gzip: gzip.checked }, ending()));
    });
    root.replaceChildren(
      element("div", { class: "export" },
        element("label", {}, "Only frames that pass the filter ", suggest(filter, (text) => app.engine.call("completions", { text }))),
        element("h2", {}, "As canvass prints them"),
        element("div", { class: "buttons" }, printed),
        element("h2", {}, "As a capture of another format"),
        element("label", {}, gzip, " compressed by gzip"),
        element("div", { class: "buttons" }, written),
      ),
    );
  }

  async function write(wish, ending) {
    const end = await app.run("export", "export", { wish }, "Writing");
    if (!end) return;
    const name = app.captures[0].name.replace(/\.(gz|zst)$/, "").replace(/\.[^.]*$/, "");
    save(`${name}-${wish.what}.${ending}`, end.blob);
    app.say(`${name}-${wish.what}.${ending}: ${counted(end.blob.size, "byte")}`);
  }

  return { refresh: fill, shown: fill };
}
