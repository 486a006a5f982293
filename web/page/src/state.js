// What is shown, in the address behind the #: so a view can be kept and sent. Nothing of a capture is in it.

const all = () => new URLSearchParams(location.hash.slice(1));

export const get = (key) => all().get(key) ?? undefined;

/** Sets some, and leaves those out that are empty. */
export function set(changes) {
  const state = all();
  for (const [key, value] of Object.entries(changes)) {
    if (value === "" || value === undefined || value === null) state.delete(key);
    else state.set(key, value);
  }
  const text = state.toString();
  if (text !== location.hash.slice(1)) history.replaceState(null, "", `#${text}`);
}
