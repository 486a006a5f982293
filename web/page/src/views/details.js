import { button, counted, element, facts, table } from "../dom.js";

/** Shows the details of one frame. */
export function showDetails(root, known, row, { goTo, jumpTo }) {
  if (!known) return root.replaceChildren();
  const close = button("×", () => root.replaceChildren(), { class: "plain close", "aria-label": "Close" });
  const parts = [
    close,
    element("h2", {}, known.text),
    facts([
      ["Time", `${known.time} s`],
      ["In the capture", known.absolute],
      ["Frame", `${row.channel} ${row.id}, line ${row.place}`],
      ["Node", row.node],
      ["Service", row.service],
      ["Object", known.object && [known.object, known.objectName].filter(Boolean).join(" ")],
    ]),
    transfer(known.transfer, jumpTo),
    section("Values", known.signals.map((signal) => [signal.name || signal.object, `${signal.value ?? ""} ${signal.unit ?? ""}`])),
    known.events.length === 0 ? null : element("h3", {}, "What it brought about"),
    known.events.map((event) => element("p", { class: "event" }, event)),
    known.bytes.length === 0 ? null : element("h3", {}, "Bits"),
    known.bytes.length === 0 ? null : bits(known.bytes),
    element("details", {}, element("summary", {}, "As JSON"), element("pre", {}, known.json)),
    button("Show in the list", () => goTo(row.row), { class: "plain" }),
  ];
  root.replaceChildren(...parts.flat().filter(Boolean));
}

function section(name, rows) {
  return rows.length > 0 ? element("div", {}, element("h3", {}, name), facts(rows)) : null;
}

/** The SDO transfer to which the frame belongs. */
function transfer(known, jumpTo) {
  if (!known) return null;
  const shown = section("SDO transfer", [
    ["Object", known.object],
    ["Direction", `${known.direction}, ${known.mode}`],
    ["Outcome", known.outcome],
    ["Value", known.value],
    ["Began", `${known.began} s`],
    ["Took", `${known.lasted} µs${known.segments > 0 ? `, ${counted(known.segments, "segment")}` : ""}`],
  ]);
  shown.append(button("Go to its first frame", () => jumpTo(Number(known.began)), { class: "plain" }));
  return shown;
}

/** Each byte with its bits, the highest first. */
function bits(bytes) {
  const rows = bytes.map((byte, at) => {
    const each = [...byte.toString(2).padStart(8, "0")].map((bit) => element("td", { class: bit === "1" ? "set" : "" }, bit));
    const hex = byte.toString(16).toUpperCase().padStart(2, "0");
    return element("tr", {}, element("th", { scope: "row" }, String(at)), element("td", {}, hex), element("td", {}, String(byte)), each);
  });
  return table(["byte", "hex", "dec", "7", "6", "5", "4", "3", "2", "1", "0"], rows, { class: "bits" });
}
