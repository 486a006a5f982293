// Elements. Content of files is only ever set as text.

/** Makes an element with attributes, listeners (`on…`) and children; strings become text. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(key, value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

export const byId = (id) => document.getElementById(id);

/** A button; `more` are its other attributes. */
export const button = (name, act, more = {}) => element("button", { type: "button", onclick: act, ...more }, name);

/** The text of a view without content, which says what the view needs. */
export const welcome = (...lines) => element("div", { class: "welcome" }, lines.map((line) => element("p", {}, line)));

/** A table with the names of its columns; rows are lists of texts, or elements made already. */
export function table(columns, rows, more = {}) {
  const head = element("tr", {}, columns.map((name) => element("th", { scope: "col" }, name)));
  const body = rows.map((row) => (row instanceof Element ? row : element("tr", {}, row.map((cell) => element("td", {}, String(cell ?? ""))))));
  return element("div", { class: "scroll" }, element("table", more, element("thead", {}, head), element("tbody", {}, body)));
}

/** A list of names and values, without names that have no value. */
export function facts(rows) {
  const shown = rows.filter(([, value]) => value !== null && value !== undefined && value !== "");
  return element("dl", {}, shown.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, String(value))]));
}

/** Offers a file for saving. */
export function save(name, content, type = "application/octet-stream") {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/** A page of a report in a frame, which has no access to this page and shares its colours. */
export function frame(title, html) {
  const url = URL.createObjectURL(new Blob([html], { type: "text/html" }));
  const shown = element("iframe", { title, sandbox: "allow-scripts", src: url });
  shown.addEventListener("load", () => URL.revokeObjectURL(url), { once: true });
  shown.addEventListener("load", () => paint(shown));
  return shown;
}

/** The colours that the user chose; empty: those of the system. */
let colours = "";

/** Sets the colours of the page and of the reports in it. */
export function setColours(chosen) {
  colours = chosen;
  document.documentElement.style.colorScheme = chosen || "light dark";
  document.querySelectorAll("iframe").forEach(paint);
}

/** The content of the frame has no origin that could be named here; the message holds no secret. */
const paint = (shown) => shown.contentWindow?.postMessage({ theme: colours }, "*");

/** Numbers with thin spaces between thousands. */
export const count = (number) => number.toLocaleString("en").replaceAll(",", "\u2009");

/** `1 frame`, `2 frames`. */
export const counted = (number, one, many = `${one}s`) => `${count(number)} ${number === 1 ? one : many}`;
