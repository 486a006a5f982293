// The state of the views, in the address after the #, so that a view can be stored and sent. The address contains no
// data of a capture.

const all = () => new URLSearchParams(location.hash.slice(1));

export const get = (key) => all().get(key) ?? undefined;

/** Changes parts of the state; empty parts are removed. A step is one that the browser's button Back undoes. */
export function set(changes, { isStep = false } = {}) {
  const state = all();
  for (const [key, value] of Object.entries(changes)) {
    if (value === "" || value === undefined || value === null) state.delete(key);
    else state.set(key, value);
  }
  const text = state.toString();
  if (text !== location.hash.slice(1)) history[isStep ? "pushState" : "replaceState"](null, "", `#${text}`);
}
