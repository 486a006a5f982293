import { element, frame } from "../dom.js";

/** Device descriptions: which nodes they are of, what is wrong in them, and their dictionary. */
export function edsView(app, root) {
  let chosen = null;

  function fill() {
    if (app.described.length === 0) {
      root.replaceChildren(element("div", { class: "welcome" }, element("p", {}, "Drop device descriptions here: EDS, DCF, XDD or XDC.")));
      return;
    }
    const page = element("div", { class: "description" });
    root.replaceChildren(element("div", { class: "cards" }, app.described.map((known) => card(known, page))), page);
    if (chosen && app.described.some(({ name }) => name === chosen)) show(chosen, page);
    else show(app.described[0].name, page);
  }

  function card(known, page) {
    const nodes = element("input", { type: "text", value: known.nodes, size: 8, "aria-label": `Nodes of ${known.name}` });
    nodes.addEventListener("change", async () => {
      await app.describe(known.name, nodes.value, known.bytes);
      await app.reopen();
    });
    const remove = async () => {
      await app.engine.call("forget", { name: known.name });
      app.described = app.described.filter((other) => other !== known);
      fill();
      await app.reopen();
    };
    return element(
      "div",
      { class: "card" },
      element("button", { type: "button", class: "link", onclick: () => show(known.name, page) }, known.name),
      element("p", {}, [known.vendor, known.product].filter(Boolean).join(" ")),
      element("p", {}, `${known.objects} objects; ${known.checked}`),
      element("label", {}, "Nodes ", nodes),
      element("button", { type: "button", class: "plain", onclick: remove }, "Remove"),
    );
  }

  async function show(name, page) {
    chosen = name;
    const [html, { findings }] = await Promise.all([
      app.engine.call("descriptionPage", { name }),
      app.engine.call("descriptionFindings", { name }),
    ]);
    if (chosen !== name) return;
    page.replaceChildren(checks(name, findings), frame(`Dictionary of ${name}`, html));
  }

  function checks(name, findings) {
    const rows = findings.map((finding) =>
      element(
        "tr",
        { class: finding.severity },
        element("td", {}, finding.severity),
        element("td", { class: "number" }, String(finding.line ?? "")),
        element("td", {}, finding.rule),
        element("td", {}, finding.message),
      ),
    );
    const head = element("tr", {}, ["severity", "line", "rule", "what"].map((text) => element("th", { scope: "col" }, text)));
    return element(
      "details",
      { class: "checks", open: findings.length > 0 && findings.length < 20 },
      element("summary", {}, findings.length === 0 ? `${name}: nothing wrong` : `${name}: ${findings.length} findings`),
      element("div", { class: "scroll" }, element("table", {}, element("thead", {}, head), element("tbody", {}, rows))),
    );
  }

  return { refresh: fill, shown() {} };
}
