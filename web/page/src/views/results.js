import { button, count, counted, element, facts, frame, table, welcome } from "../dom.js";

const WELCOME = "Drop results here: the JSON of canvass test, fuzz, compare or history. Two results of test are compared, more become a history; simulated devices under Try it make some.";

/** The view of results of `canvass test`, `fuzz` and `compare` that were dropped as JSON. */
export function resultsView(app, root) {
  const page = element("div", { class: "description" });

  function fill() {
    if (app.results.length === 0) return root.replaceChildren(welcome(WELCOME));
    const read = app.results.map(([name, bytes]) => ({ name, bytes, known: parse(bytes) }));
    const tests = read.filter(({ known }) => known?.schema?.startsWith("canvass/test/"));
    const pairs = tests.map(({ name, bytes }) => [name, bytes]);
    const cards = [];
    if (tests.length === 2) cards.push(button("Compare both", () => report("compare", pairs)));
    if (tests.length > 1) cards.push(button("History of all", () => report("history", pairs)));
    if (read.length > 1) cards.push(button("Remove all", () => keep([])));
    cards.push(...read.map((one) => card(one)));
    root.replaceChildren(element("div", { class: "cards" }, cards), page);
    if (tests.length === 2) report("compare", pairs);
    else if (tests.length > 2) report("history", pairs);
    else show(read.at(-1));
  }

  function keep(results) {
    app.results = results;
    fill();
  }

  function card(one) {
    const remove = button("Remove", () => keep(app.results.filter(([name]) => name !== one.name)), { class: "plain", "aria-label": `Remove ${one.name}` });
    return element("div", { class: "card" }, button(one.name, () => show(one), { class: "link" }), element("p", {}, told(one.known)), remove);
  }

  async function report(call, results) {
    try {
      page.replaceChildren(frame(call, await app.engine.call(call, { results })));
    } catch (error) {
      page.replaceChildren(welcome(error.message));
    }
  }

  /** Shows the rows of a result; each row opens to its details. */
  function show({ name, known }) {
    const rows = known ? rowsOf(known) : null;
    if (!rows) return page.replaceChildren(welcome(`${name} is no result of canvass: ${told(known)}.`));
    const filter = element("input", { type: "search", placeholder: "Filter", "aria-label": "Filter of the rows" });
    const shown = element("span", { class: "shown", role: "status" });
    const body = element("div", { class: "results" });
    const fill = () => {
      const wanted = filter.value.toLowerCase();
      const fit = rows.filter((row) => row.searched.includes(wanted));
      shown.textContent = `${count(fit.length)} of ${count(rows.length)}`;
      body.replaceChildren(head(known), ...fit.map(entry));
    };
    filter.addEventListener("input", fill);
    page.replaceChildren(element("div", { class: "bar" }, element("strong", {}, `${name}: ${told(known)}`), filter, shown), body);
    fill();
  }

  return { refresh: fill };
}

function parse(bytes) {
  try {
    const known = JSON.parse(new TextDecoder().decode(bytes));
    return known && typeof known === "object" ? known : null;
  } catch {
    return null;
  }
}

/** A summary of a result. */
function told(known) {
  if (!known) return "it is not JSON";
  const counts = known.summary && typeof known.summary === "object" ? Object.entries(known.summary) : [];
  const shown = counts.filter(([, value]) => typeof value === "number" && value > 0).map(([name, value]) => `${count(value)} ${name.replaceAll("_", " ")}`);
  if (shown.length > 0) return shown.join(", ");
  if (Array.isArray(known.violations)) return `${counted(known.violations.length, "violation")} in ${counted(known.executions ?? 0, "exchange")}`;
  return typeof known.schema === "string" ? known.schema : "it names no schema";
}

/** The device and the conditions of the test. */
function head(known) {
  const { device = {}, provenance = {} } = known;
  return facts([
    ["Bus", known.bus],
    ["Node", known.node],
    ["Model", known.model],
    ["Device", [device?.name, device?.hardware_version, device?.software_version].filter(Boolean).join(", ")],
    ["Seed", known.seed],
    ["Repeat", known.repeat],
    ["Made", typeof provenance?.date === "string" ? provenance.date : provenance?.date?.rfc3339],
    ["Notices", Array.isArray(known.notices) ? known.notices.join("; ") : null],
  ]);
}

/** The verdicts in the order of their rows: the most important first. */
const ORDER = ["fail", "error", "inconclusive", "deviation", "tolerated", "pass", "not_applicable"];
const list = (value) => (Array.isArray(value) ? value : []);

/** The entries of a result; null if it has none of a known kind. */
function rowsOf(known) {
  const row = (kind, title, text, parts, whole) => ({ kind, title, text, parts, whole, searched: JSON.stringify(whole).toLowerCase() });
  if (Array.isArray(known.cases) && known.cases.every((one) => one?.id && one.verdict)) {
    const rows = known.cases.map((one) => row(one.verdict, one.id, one.reason ? `expected ${one.reason.expected}, got ${one.reason.actual}` : one.requirement, () => ofCase(one), one));
    return rows.sort((a, b) => ORDER.indexOf(a.kind) - ORDER.indexOf(b.kind));
  }
  if (Array.isArray(known.violations)) {
    return known.violations.map((one) => row("fail", one.property, `expected ${one.expected}, got ${one.actual}`, () => ofViolation(one), one));
  }
  if (Array.isArray(known.changes)) {
    return known.changes.map((one) => row(one.direction ?? one.kind ?? "", one.subject ?? one.id ?? "", `${one.old ?? "-"} → ${one.new ?? "-"}${one.reason ? `: ${one.reason}` : ""}`, () => [], one));
  }
  if (Array.isArray(known.findings)) {
    return known.findings.map((one) => row(one.severity ?? "", one.rule ?? "", one.message, () => [], one));
  }
  return typeof known.schema === "string" ? [row("", known.schema, "", () => [], known)] : null;
}

/** The details of a case. */
function ofCase(one) {
  return [
    facts([
      ["Requirement", one.requirement],
      ["Clause", [one.clause, one.clause_confidence].filter(Boolean).join(", ")],
      ["Level", one.level],
      ["Expected", one.reason?.expected],
      ["Found", one.reason?.actual],
      ["Documented", one.documented],
      ["Notes", list(one.notes).join("; ")],
      ...list(one.measurements).map(({ name, value, unit }) => [name, `${value} ${unit}`]),
    ]),
    list(one.breaches).length > 0 ? table(["Subject", "Verdict", "Expected", "Found"], one.breaches.map((breach) => [breach.subject, breach.verdict, breach.expected, breach.actual])) : null,
    frames("Evidence", one.evidence),
  ];
}

/** The details of a violation. */
function ofViolation(one) {
  return [
    facts([["Property", one.title], ["Rule", one.rule], ["Expected", one.expected], ["Found", one.actual], ["Confirmed", one.confirmed ? "whenever it is repeated" : "no, it was seen once"]]),
    frames("The shortest sequence", one.frames),
    frames("On the bus", one.evidence),
    element("h2", {}, "To be sent again, as a candump log"),
    element("pre", {}, one.log ?? ""),
  ];
}

function frames(title, rows) {
  if (list(rows).length === 0) return null;
  const id = (one) => (typeof one.id === "number" ? one.id.toString(16).toUpperCase().padStart(3, "0") : one.id);
  const seconds = (one) => (typeof one.t === "number" ? (one.t / 1e9).toFixed(6) : "");
  return element("div", {}, element("h2", {}, title), table(["Time [s]", "Direction", "CAN-ID", "Data", "Meaning"], rows.map((one) => [seconds(one), one.direction, id(one), one.data, one.text]), { class: "evidence" }));
}

/** A row, whose details are made when it is opened. */
function entry({ kind, title, text, parts, whole }) {
  const summary = element("summary", {}, element("span", { class: "verdict" }, kind.replaceAll("_", " ")), element("strong", {}, title), element("span", { class: "why" }, text ?? ""));
  const details = element("details", { class: `entry ${/^[a-z_]+$/.test(kind) ? kind : ""}` }, summary);
  const open = () => details.append(...parts().filter(Boolean), element("details", {}, element("summary", {}, "As JSON"), element("pre", {}, JSON.stringify(whole, null, 1))));
  details.addEventListener("toggle", open, { once: true });
  return details;
}
