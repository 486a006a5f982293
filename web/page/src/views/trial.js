import { button, byId, element, frame, save } from "../dom.js";
import { suggest } from "../suggest.js";

/** The view of simulated devices, which the page tests and fuzzes without hardware in virtual time. */
export function trialView(app, root) {
  let choices = null;
  let engine = null;
  const on = new Set(app.state.get("faults")?.split(",") ?? []);
  const page = element("div", { class: "description" });
  const model = element("select", { id: "try-model" });
  const about = element("p", { class: "note" });
  const select = element("input", { id: "try-select", type: "text", placeholder: "all cases", size: 16, "aria-label": "Cases" });
  const seconds = element("input", { id: "try-seconds", type: "number", min: 1, max: 3600, value: 5 });
  const seed = element("input", { id: "try-seed", type: "number", min: 0, value: 0 });
  const allow = element("input", { type: "checkbox", id: "try-allow" });
  const search = element("input", { type: "search", id: "try-search", placeholder: "Filter of the faults", "aria-label": "Filter of the faults" });
  const switches = element("fieldset", { class: "switches", id: "try-faults" });
  const command = element("code", { id: "try-command" });

  function build() {
    model.replaceChildren(...choices.models.map(({ id }) => element("option", { value: id }, id)));
    model.value = app.state.get("model") ?? "kuebler-sendix-58x8";
    select.value = app.state.get("select") ?? "";
    seconds.value = app.state.get("seconds") ?? "5";
    seed.value = app.state.get("seed") ?? "0";
    allow.checked = app.state.get("allow") === "all";
    model.addEventListener("change", changed);
    [select, seconds, seed, allow].forEach((input) => input.addEventListener("input", told));
    search.addEventListener("input", list);
    const label = (name, input) => element("label", {}, `${name} `, input);
    const cases = suggest(select, families);
    root.replaceChildren(
      element("div", { class: "bar" },
        label("Device", model), label("Cases", cases), button("Test", () => go("test"), { id: "try-test", class: "main" }),
        label("Seconds", seconds), label("Seed", seed), button("Fuzz", () => go("fuzz"), { id: "try-fuzz", class: "main" }),
        element("label", {}, allow, " also what changes the device for good"), command,
      ),
      element("div", { class: "split" }, element("div", { class: "faults" }, about, search, switches), page),
    );
    changed();
    page.replaceChildren(element("p", { class: "welcome" }, "A simulated device, in this page: switch faults of its firmware on, run the cases or the fuzzer, and see what they find."));
  }

  /** Suggests families of cases for the last word of a comma-separated list. */
  function families(text) {
    const from = text.lastIndexOf(",") + 1;
    const begun = text.slice(from).trim();
    return { from, words: choices.families.filter((family) => family.startsWith(begun) && family !== begun) };
  }

  function changed() {
    about.textContent = choices.models.find(({ id }) => id === model.value)?.summary ?? "";
    const own = new Set(faults().map(({ id }) => id));
    [...on].filter((id) => !own.has(id)).forEach((id) => on.delete(id));
    told();
    list();
  }

  /** Keeps the choices in the address, and shows the equivalent command line. */
  function told() {
    const { seconds, seed } = wished();
    app.state.set({ model: model.value, faults: [...on].join(","), select: select.value, seconds: seconds === 5 ? "" : seconds, seed: seed || "", allow: allow.checked ? "all" : "" });
    command.textContent = line("test", wished());
  }

  const wished = () => ({ bus: bus(), select: select.value, allow: allow.checked, seconds: Number(seconds.value) || 5, seed: Math.max(0, Math.trunc(Number(seed.value) || 0)) });

  /** The equivalent command line of the program. */
  function line(kind, { bus, select, allow, seconds, seed }) {
    const chosen = kind === "test" ? select && ` --select ${select}` : ` --for ${seconds}s`;
    const chance = kind === "fuzz" || seed > 0 ? ` --seed ${seed}` : "";
    return `canvass ${kind} ${bus}${chosen}${chance}${allow ? " --allow all" : ""}`;
  }

  /** The faults that show on the chosen model. */
  const faults = () => choices.faults.filter((one) => one.model === model.value || one.model === "reference-301");

  const bus = () => ["sim:" + model.value, ...on].join("+");

  function list() {
    const wanted = search.value.toLowerCase();
    const rows = faults().filter(({ id, summary }) => `${id} ${summary}`.toLowerCase().includes(wanted)).map(({ id, summary }) => {
      const box = element("input", { type: "checkbox", value: id, checked: on.has(id) });
      box.addEventListener("change", () => {
        if (box.checked) on.add(id);
        else on.delete(id);
        told();
      });
      return element("label", {}, box, element("span", {}, element("strong", {}, id), element("span", { class: "summary" }, summary)));
    });
    switches.replaceChildren(element("legend", { class: "unseen" }, "Faults of the firmware"), ...rows);
  }

  /** Runs a trial in a worker of its own, as it does not answer until its end: to cancel it, the worker is ended. */
  async function go(kind) {
    engine ??= await app.engine.sibling((why) => app.say(why, true));
    const wish = wished();
    const box = byId("progress");
    const [bar, text, cancel] = box.children;
    box.hidden = false;
    bar.value = 0;
    cancel.onclick = () => engine.restart();
    const name = line(kind, wish);
    text.textContent = name;
    try {
      const tried = await engine.call("trial", { kind, wish }, ({ done, all, what }) => {
        bar.value = done / Math.max(1, all);
        text.textContent = `${name}: ${what}`;
      });
      show(kind, name, tried);
      app.say(`${name}: done`);
    } catch (error) {
      app.say(`${name}: ${error.message}`, error.message !== "stopped");
    } finally {
      box.hidden = true;
    }
  }

  function show(kind, name, tried) {
    const buttons = [["html", "text/html"], ["json", "application/json"]].map(([form, type]) =>
      button(form, () => save(`${kind}.${form}`, tried[form], type), { class: "plain" }),
    );
    const keep = button("Keep under Results", () => {
      app.addResults([[`${kind} ${bus()} ${new Date().toLocaleTimeString()}`, tried.json]]);
      app.say("Kept: two results of test are compared under Results");
    }, { class: "plain" });
    page.replaceChildren(element("div", { class: "bar" }, element("code", {}, name), element("span", {}, "Save as "), buttons, keep), frame(name, tried.html));
  }

  return {
    async shown() {
      if (choices || !app.engine) return;
      choices = await app.engine.call("choices");
      build();
    },
  };
}
