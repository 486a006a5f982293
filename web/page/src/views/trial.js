import { byId, element, frame, save } from "../dom.js";

/** Simulated devices, to be tested and fuzzed in the page, without hardware and in no time. */
export function trialView(app, root) {
  let choices = null;
  let engine = null;
  const page = element("div", { class: "description" });

  async function build() {
    choices = await app.engine.call("choices");
    const models = choices.models.map(({ id, summary }) => element("option", { value: id, title: summary }, id));
    const model = element("select", { id: "try-model" }, models);
    const fault = element("select", { id: "try-fault" });
    const select = element("input", { id: "try-select", type: "text", list: "families", placeholder: "all cases", size: 18 });
    const families = element("datalist", { id: "families" }, choices.families.map((value) => element("option", { value })));
    const sequences = element("input", { id: "try-sequences", type: "number", min: 1, max: 100000, value: 200, size: 6 });
    const allow = element("input", { type: "checkbox", id: "try-allow" });
    model.value = app.state.get("model") ?? "kuebler-sendix-58x8";
    const faults = () => {
      const own = choices.faults.filter((one) => one.model === model.value || one.model === "reference-301");
      fault.replaceChildren(element("option", { value: "" }, "none"), ...own.map(({ id, summary }) => element("option", { value: id, title: summary }, id)));
    };
    model.addEventListener("change", faults);
    faults();
    fault.value = app.state.get("fault") ?? "";
    const wish = () => {
      app.state.set({ model: model.value, fault: fault.value });
      const bus = `sim:${model.value}${fault.value ? `+${fault.value}` : ""}`;
      return { bus, select: select.value, allow: allow.checked, sequences: Number(sequences.value) || 200 };
    };
    const label = (name, input) => element("label", {}, `${name} `, input);
    root.replaceChildren(
      element("div", { class: "bar" },
        label("Device", model), label("Fault of its firmware", fault), label("Cases", select), families,
        element("button", { type: "button", id: "try-test", onclick: () => go("test", wish()) }, "Test"),
        label("Sequences", sequences),
        element("button", { type: "button", id: "try-fuzz", onclick: () => go("fuzz", wish()) }, "Fuzz"),
        label("Everything is allowed", allow),
      ),
      page,
    );
  }

  /** In a worker of its own, as it runs to its end at once: cancelled, it is ended. */
  async function go(kind, wish) {
    engine ??= await app.engine.sibling((why) => app.say(why, true));
    const box = byId("progress");
    const [bar, text, cancel] = box.children;
    box.hidden = false;
    bar.value = 0;
    cancel.onclick = () => engine.restart();
    const command = `canvass ${kind} ${wish.bus}`;
    try {
      const tried = await engine.call("trial", { kind, wish }, ({ done, all, what }) => {
        bar.value = done / Math.max(1, all);
        text.textContent = `${command}: ${done} of ${all}, ${what}`;
      });
      const buttons = [["html", "text/html"], ["json", "application/json"]].map(([form, type]) =>
        element("button", { type: "button", class: "plain", onclick: () => save(`${kind}.${form}`, tried[form], type) }, form),
      );
      page.replaceChildren(element("div", { class: "bar" }, element("code", {}, command), " Save as ", buttons), frame(command, tried.html));
      app.say(`${command}: done`);
    } catch (error) {
      app.say(`${command}: ${error.message}`, error.message !== "stopped");
    } finally {
      box.hidden = true;
    }
  }

  return {
    shown() {
      if (!choices && app.engine) build();
    },
  };
}
