import { element, frame } from "../dom.js";

/** Results of `canvass test`, `fuzz` and `compare` that were dropped as JSON. */
export function resultsView(app, root) {
  function fill() {
    if (app.results.length === 0) {
      const text = "Drop results here: the JSON of canvass test, fuzz or compare. Two results of test are compared, more become a history.";
      root.replaceChildren(element("div", { class: "welcome" }, element("p", {}, text)));
      return;
    }
    const page = element("div", { class: "description" });
    const read = app.results.map(([name, text]) => ({ name, text, known: parse(text) }));
    const tests = read.filter(({ known }) => known?.schema?.startsWith("canvass/test/"));
    const pairs = tests.map(({ name, text }) => [name, text]);
    const cards = read.map((one) => card(one, page));
    if (tests.length === 2) cards.push(button("Compare both", () => report("compare", pairs, page)));
    if (tests.length > 1) cards.push(button("History of all", () => report("history", pairs, page)));
    cards.push(button("Remove all", () => {
      app.results = [];
      fill();
    }));
    root.replaceChildren(element("div", { class: "cards" }, cards), page);
    if (tests.length === 2) report("compare", pairs, page);
    else if (tests.length > 2) report("history", pairs, page);
    else show(read.at(-1), page);
  }

  const button = (name, act) => element("button", { type: "button", onclick: act }, name);

  function parse(text) {
    try {
      return JSON.parse(text);
    } catch {
      return null;
    }
  }

  function card(one, page) {
    const summary = one.known ? told(one.known) : "is no JSON";
    return element("div", { class: "card" }, element("button", { type: "button", class: "link", onclick: () => show(one, page) }, one.name), element("p", {}, summary));
  }

  async function report(call, results, page) {
    try {
      page.replaceChildren(frame(call, await app.engine.call(call, { results })));
    } catch (error) {
      app.say(error.message, true);
    }
  }

  /** The rows of a result, with what each says in full. */
  function show({ name, known }, page) {
    if (!known) return page.replaceChildren(element("p", { class: "welcome" }, `${name} is no result`));
    const filter = element("input", { type: "text", placeholder: "Filter", "aria-label": "Filter of the rows" });
    const body = element("div", { class: "results" });
    const rows = rowsOf(known);
    const fill = () => {
      const wanted = filter.value.toLowerCase();
      body.replaceChildren(...rows.filter((row) => JSON.stringify(row).toLowerCase().includes(wanted)).map(entry));
    };
    filter.addEventListener("input", fill);
    page.replaceChildren(element("div", { class: "bar" }, element("strong", {}, `${name}: ${told(known)}`), filter), body);
    fill();
  }

  function entry({ kind, title, text, whole }) {
    const details = element("details", { class: `entry ${kind}` }, element("summary", {}, element("span", { class: "verdict" }, kind), ` ${title}`), element("p", {}, text ?? ""));
    details.addEventListener("toggle", () => details.append(element("pre", {}, JSON.stringify(whole, null, 1))), { once: true });
    return details;
  }

  return { refresh: fill, shown() {} };
}

/** Those first that are worth it. */
const ORDER = ["fail", "error", "inconclusive", "deviation", "tolerated", "pass", "not_applicable"];

function rowsOf(known) {
  if (Array.isArray(known.cases)) {
    const rows = known.cases.map((one) => ({ kind: one.verdict, title: one.id, text: one.reason, whole: one }));
    return rows.sort((a, b) => ORDER.indexOf(a.kind) - ORDER.indexOf(b.kind));
  }
  if (Array.isArray(known.violations)) {
    return known.violations.map((one) => ({ kind: "fail", title: one.property, text: `expected ${one.expected}, got ${one.actual}`, whole: one }));
  }
  if (Array.isArray(known.changes)) {
    return known.changes.map((one) => ({ kind: one.kind ?? "", title: one.subject ?? one.id ?? "", text: one.text ?? one.message, whole: one }));
  }
  return [{ kind: "", title: "the whole document", whole: known }];
}

function told(known) {
  const counts = known.summary && typeof known.summary === "object" ? Object.entries(known.summary) : [];
  const shown = counts.filter(([, value]) => typeof value === "number" && value > 0).map(([name, value]) => `${value} ${name.replaceAll("_", " ")}`);
  if (shown.length > 0) return shown.join(", ");
  if (Array.isArray(known.violations)) return `${known.violations.length} violations in ${known.executions ?? "?"} exchanges`;
  return known.schema ?? "a document of another program";
}
