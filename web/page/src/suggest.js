// Suggestions while the user types: a combobox, as ARIA describes it.
import { element } from "./dom.js";

let made = 0;

/** Adds suggestions to an input; `ask(text)` returns words for the text before the caret, and where the word begins. */
export function suggest(input, ask) {
  const id = `words-${made++}`;
  const list = element("ul", { id, class: "words", role: "listbox", "aria-label": "What can stand here", hidden: true });
  const box = element("span", { class: "combo" }, input, list);
  let from = 0;
  let at = -1;
  const attributes = { role: "combobox", "aria-autocomplete": "list", "aria-controls": id, "aria-expanded": "false", autocomplete: "off" };
  Object.entries(attributes).forEach(([name, value]) => input.setAttribute(name, value));

  function close() {
    list.hidden = true;
    at = -1;
    input.setAttribute("aria-expanded", "false");
    input.removeAttribute("aria-activedescendant");
  }

  async function open() {
    const text = input.value.slice(0, input.selectionStart);
    const known = await ask(text);
    if (document.activeElement !== input || text !== input.value.slice(0, input.selectionStart)) return;
    from = known.from;
    const option = (word, n) => element("li", { id: `${id}-${n}`, role: "option", "aria-selected": "false", onpointerdown: (event) => take(event, word) }, word.trim());
    list.replaceChildren(...known.words.map(option));
    list.words = known.words;
    if (known.words.length === 0) return close();
    at = -1;
    list.hidden = false;
    input.setAttribute("aria-expanded", "true");
    input.removeAttribute("aria-activedescendant");
  }

  /** Inserts a word; the input keeps the focus. */
  function take(event, word) {
    event.preventDefault();
    input.setRangeText(word, from, input.selectionStart, "end");
    close();
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }

  function move(to) {
    const { children } = list;
    at = (to + children.length) % children.length;
    [...children].forEach((child, n) => child.setAttribute("aria-selected", n === at));
    children[at].scrollIntoView({ block: "nearest" });
    input.setAttribute("aria-activedescendant", children[at].id);
  }

  input.addEventListener("input", open);
  input.addEventListener("click", open);
  input.addEventListener("blur", close);
  input.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (list.hidden) {
      if (step === 1) open();
      return;
    }
    if (step) move(at < 0 && step < 0 ? -1 : at + step);
    else if (event.key === "Escape") close();
    else if ((event.key === "Enter" || event.key === "Tab") && at >= 0) return take(event, list.words[at]);
    else return;
    event.preventDefault();
  });
  return box;
}
