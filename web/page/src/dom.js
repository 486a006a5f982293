// Elements. What comes out of files is only ever set as text.

/** An element with attributes, listeners (`on…`) and children; strings become text. */
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

/** Offers a file to be saved. */
export function save(name, content, type = "application/octet-stream") {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/** A page of a report, in a frame that reaches nothing around it. */
export function frame(title, html) {
  const url = URL.createObjectURL(new Blob([html], { type: "text/html" }));
  const shown = element("iframe", { title, sandbox: "allow-scripts", src: url });
  shown.addEventListener("load", () => URL.revokeObjectURL(url), { once: true });
  return shown;
}

/** Numbers with thin spaces between thousands. */
export const count = (number) => number.toLocaleString("en").replaceAll(",", "\u2009");
