// The page's side of the worker: each call is a promise.

/** Starts the worker from the script in the page: nothing is loaded. */
export async function start(onStopped) {
  const script = document.getElementById("worker").textContent;
  const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const engine = new Engine(url, await module(), onStopped);
  await engine.begin();
  return engine;
}

/** The WebAssembly, from base64 text compressed by gzip. */
async function module() {
  const text = document.getElementById("wasm").textContent.trim();
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(stream).arrayBuffer());
}

class Engine {
  #worker;
  #waiting = new Map();
  #next = 0;

  constructor(url, module, onStopped) {
    this.url = url;
    this.module = module;
    this.onStopped = onStopped;
  }

  async begin() {
    this.#worker = new Worker(this.url);
    this.#worker.onmessage = ({ data }) => this.#take(data);
    this.#worker.onerror = (event) => this.onStopped(event.message);
    const { formats } = await this.call("start", { module: this.module, surroundings: surroundings() });
    this.formats = formats;
  }

  /** Another worker with the same program, for work that does not answer until its end. */
  async sibling(onStopped) {
    const other = new Engine(this.url, this.module, onStopped);
    await other.begin();
    return other;
  }

  /** Ends all work in progress, and starts the worker again. */
  async restart() {
    this.#worker.terminate();
    this.#waiting.forEach(({ reject }) => reject(new Error("stopped")));
    this.#waiting.clear();
    await this.begin();
  }

  /** Calls a function of the worker with these arguments; the objects in `moved` are transferred, not copied. */
  call(call, args = {}, progress = () => {}, moved = []) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, progress });
      this.#worker.postMessage({ id, call, args }, moved);
    });
  }

  #take({ id, result, error, progress, stopped }) {
    if (stopped !== undefined) return this.onStopped(stopped);
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    if (progress !== undefined) return waiting.progress(progress);
    this.#waiting.delete(id);
    if (error !== undefined) waiting.reject(new Error(error));
    else waiting.resolve(result);
  }
}

/** The surroundings in which a report is made. */
function surroundings() {
  const now = new Date();
  const minutes = -now.getTimezoneOffset();
  const two = (number) => String(Math.floor(Math.abs(number))).padStart(2, "0");
  const local = new Date(now.getTime() + minutes * 60_000).toISOString().slice(0, 19);
  return {
    host: "a browser",
    system: navigator.userAgentData?.platform ?? navigator.platform ?? "unknown",
    date: `${local}${minutes < 0 ? "-" : "+"}${two(minutes / 60)}:${two(minutes % 60)}`,
    zone: Intl.DateTimeFormat().resolvedOptions().timeZone ?? "UTC",
  };
}
