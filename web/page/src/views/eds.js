import { button, counted, element, frame, table, welcome } from "../dom.js";

/** The view of device descriptions: their nodes, findings and dictionaries. */
export function edsView(app, root) {
  let chosen = null;

  function fill() {
    if (app.described.length === 0) {
      root.replaceChildren(welcome("Drop device descriptions here: EDS, DCF, XDD or XDC. They name what captures show, and are checked."));
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
      if (await app.describe(known.name, nodes.value, known.bytes)) await app.reopen();
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
      button(known.name, () => show(known.name, page), { class: "link" }),
      element("p", {}, [known.vendor, known.product].filter(Boolean).join(" ")),
      element("p", {}, `${counted(known.objects, "object")}; ${known.checked}`),
      element("label", {}, "Nodes ", nodes),
      button("Remove", remove, { class: "plain" }),
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
    return element(
      "details",
      { class: "checks", open: findings.length > 0 && findings.length < 20 },
      element("summary", {}, findings.length === 0 ? `${name}: nothing wrong` : `${name}: ${counted(findings.length, "finding")}`),
      table(["Severity", "Line", "Rule", "What"], rows),
    );
  }

  return { refresh: fill, shown() {} };
}
