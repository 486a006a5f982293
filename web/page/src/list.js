// A list of millions of rows, which has elements only for the visible ones. Libraries for this give the list its full
// height, which browsers limit (17 to 33 million pixels): here a long list scrolls in proportion.

import { element } from "./dom.js";

const ROW = 24;
/** Height of the column names in pixels. */
const HEAD = 28;
/** Maximum height in pixels that every browser can scroll. */
const TALLEST = 8_000_000;
/** Number of rows that are fetched at once, and number of such pieces that are kept. */
const PIECE = 128;
const KEPT = 200;

export class List {
  #length = 0;
  #top = 0;
  #pieces = new Map();
  #generation = 0;
  #rows = [];
  #drawn = false;
  /** Number of visible rows at the last resize. */
  #before = 0;

  /** `fetch(from, count)` returns rows, `draw(element, row)` shows one, `choose(row)` gets the selected row. */
  constructor(root, { head, fetch, draw, choose, label }) {
    Object.assign(this, { root, fetch, draw, choose });
    this.at = 0;
    /** Whether the row at `at` is selected; otherwise `at` is where the selected row would be. */
    this.selected = true;
    this.height = element("div", { class: "list-height", role: "presentation" });
    this.body = element("div", { class: "list-body", role: "rowgroup" });
    head.setAttribute("aria-rowindex", 1);
    root.append(element("div", { class: "list-head", role: "rowgroup" }, head), this.height, this.body);
    root.tabIndex = 0;
    root.setAttribute("role", "grid");
    root.setAttribute("aria-label", label);
    root.addEventListener("scroll", () => this.#scrolled());
    root.addEventListener("keydown", (event) => this.#key(event));
    root.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    new ResizeObserver(() => this.#resized()).observe(root);
  }

  get #sight() {
    return Math.max(1, Math.ceil((this.root.clientHeight - HEAD) / ROW));
  }

  get #scaled() {
    return this.#length * ROW > TALLEST;
  }

  get length() {
    return this.#length;
  }

  /** Replaces all rows. */
  reset(length) {
    this.#generation++;
    this.#pieces.clear();
    this.grow(length);
    this.at = Math.min(this.at, Math.max(0, length - 1));
    this.#schedule();
  }

  /** Adds further rows. */
  grow(length) {
    this.#length = length;
    this.root.setAttribute("aria-rowcount", length + 1);
    this.height.style.height = `${Math.min(length * ROW, TALLEST)}px`;
    const rest = length % PIECE;
    for (const [piece, rows] of this.#pieces) if (rows.length < PIECE && rest !== rows.length) this.#pieces.delete(piece);
    this.#schedule();
  }

  /** Marks the place of the row that was selected before the rows changed, which may be among them or not. */
  place(at, selected) {
    this.at = Math.max(0, Math.min(at, this.#length - 1));
    this.selected = selected;
    const sight = this.#sight - 1;
    if (this.at < this.#top || this.at >= this.#top + sight) this.#show(this.at - Math.floor(sight / 2));
    this.#schedule();
  }

  /** The row at a place. */
  row(at) {
    return this.#row(at);
  }

  /** Scrolls to a row and selects it; `why` is passed on to `choose`. */
  go(at, why) {
    if (this.#length === 0) return;
    this.selected = true;
    this.at = Math.max(0, Math.min(at, this.#length - 1));
    const sight = this.#sight - 1;
    if (this.at < this.#top || this.at >= this.#top + sight) this.#show(this.at - Math.floor(sight / 2));
    this.#schedule();
    this.#row(this.at).then((row) => row && this.choose(row, why));
  }

  /** Keeps the selected row visible when the list gets lower, as when the details of a row open on a phone. */
  #resized() {
    const wasInSight = this.at >= this.#top && this.at < this.#top + this.#before;
    this.#before = this.#sight - 1;
    if (wasInSight && this.at >= this.#top + this.#before) this.#show(this.at - Math.floor(this.#before / 2));
    this.#schedule();
  }

  /** Scrolls a row to the top. */
  #show(top) {
    this.#top = Math.max(0, Math.min(top, this.#length - this.#sight + 1));
    const range = Math.max(1, this.root.scrollHeight - this.root.clientHeight);
    const most = Math.max(1, this.#length - this.#sight + 1);
    this.ignore = true;
    this.root.scrollTop = this.#scaled ? (this.#top / most) * range : this.#top * ROW;
    requestAnimationFrame(() => (this.ignore = false));
    this.#schedule();
  }

  #scrolled() {
    if (!this.ignore) {
      const range = Math.max(1, this.root.scrollHeight - this.root.clientHeight);
      const most = Math.max(0, this.#length - this.#sight + 1);
      const part = this.root.scrollTop / range;
      this.#top = this.#scaled ? Math.round(part * most) : Math.floor(this.root.scrollTop / ROW);
    }
    this.#schedule();
  }

  /** Scrolls by rows for a turn of the wheel, even if a pixel stands for thousands of rows. */
  #wheel(event) {
    if (!this.#scaled || event.ctrlKey) return;
    event.preventDefault();
    this.#show(this.#top + Math.sign(event.deltaY) * Math.max(1, Math.round(Math.abs(event.deltaY) / ROW)));
  }

  #key(event) {
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: this.#sight - 2, PageUp: 2 - this.#sight, Home: -this.#length, End: this.#length };
    const step = steps[event.key];
    if (step === undefined || event.target !== this.root) return;
    event.preventDefault();
    // From a place between two rows, the next row is the one at the place.
    this.go(this.at + (this.selected || step < 0 ? step : step - 1));
  }

  async #row(at) {
    const piece = await this.#piece(Math.floor(at / PIECE));
    return piece[at % PIECE];
  }

  async #piece(number) {
    const known = this.#pieces.get(number);
    if (known) return known;
    const generation = this.#generation;
    const rows = await this.fetch(number * PIECE, PIECE);
    if (generation === this.#generation) {
      this.#pieces.set(number, rows);
      if (this.#pieces.size > KEPT) this.#pieces.delete(this.#pieces.keys().next().value);
    }
    return rows;
  }

  #schedule() {
    if (this.#drawn) return;
    this.#drawn = true;
    requestAnimationFrame(() => {
      this.#drawn = false;
      this.#draw();
    });
  }

  #draw() {
    const sight = Math.min(this.#sight + 1, this.#length);
    while (this.#rows.length < sight) {
      const row = element("div", { class: "row", role: "row" });
      row.addEventListener("click", () => this.go(row.at));
      this.#rows.push(row);
      this.body.append(row);
    }
    while (this.#rows.length > sight) this.#rows.pop().remove();
    const offset = this.#scaled ? 0 : this.root.scrollTop - this.#top * ROW;
    this.body.style.transform = `translateY(${this.root.scrollTop - offset}px)`;
    const wanted = new Set();
    this.#rows.forEach((row, n) => {
      row.at = this.#top + n;
      row.hidden = row.at >= this.#length;
      const known = this.#pieces.get(Math.floor(row.at / PIECE))?.[row.at % PIECE];
      if (!known && !row.hidden) wanted.add(Math.floor(row.at / PIECE));
      row.setAttribute("aria-rowindex", row.at + 2);
      row.setAttribute("aria-selected", row.at === this.at && this.selected);
      row.id = `row-${n}`;
      this.draw(row, known);
      if (row.at === this.at) this.root.setAttribute("aria-activedescendant", row.id);
    });
    if (wanted.size > 0) this.#fetchSoon([...wanted]);
  }

  /** Fetches the visible pieces, one set after the other: rows that are only scrolled past are not fetched. */
  async #fetchSoon(wanted) {
    if (this.fetching) return;
    this.fetching = true;
    try {
      await Promise.all(wanted.map((piece) => this.#piece(piece)));
    } finally {
      this.fetching = false;
    }
    // The call draws at once, so that the next frame of the screen shows the rows.
    this.#draw();
  }
}
