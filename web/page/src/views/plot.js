// Values over time, drawn by uPlot: an axis for each unit, two cursors.
import uPlot from "uplot";

export const COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#d9730d", "#9467bd", "#0f97a8", "#8c564b", "#c2559d"];
const MARKS = [["A", "#c2185b"], ["B", "#00838f"]];

const scale = (unit) => `unit ${unit}`;

/**
 * A plot in an element. `points(column, from, to, parts)` returns times and values, `marks()` the cursors' times;
 * `mark(seconds, other)` is called when the user sets the first or the other cursor.
 */
export function plotOf(area, { points, marks, mark }) {
  let plot = null;
  let drawn = [];
  let turn = 0;

  /** The values of a span, on a common time axis. */
  async function data(from, to) {
    const parts = Math.max(200, area.clientWidth);
    const all = await Promise.all(drawn.map(({ column }) => points(column, from, to, parts)));
    const tables = all.map((numbers) => {
      const [times, values] = [[], []];
      for (let n = 0; n < numbers.length; n += 2) {
        if (numbers[n] === times.at(-1)) values[values.length - 1] = numbers[n + 1];
        else {
          times.push(numbers[n]);
          values.push(numbers[n + 1]);
        }
      }
      return [times, values];
    });
    return tables.length > 0 ? uPlot.join(tables) : [[0, 1]];
  }

  const size = () => ({ width: Math.max(200, area.clientWidth), height: Math.max(160, area.clientHeight - 4) });

  async function show(from = -Infinity, to = Infinity) {
    const own = ++turn;
    const values = await data(from, to);
    if (own !== turn) return;
    plot?.destroy();
    const units = [...new Set(drawn.map(({ unit }) => unit))];
    const text = () => getComputedStyle(area).color;
    const grid = { stroke: "rgba(128,128,128,0.25)", width: 1 };
    const axes = units.map((unit, n) => ({ scale: scale(unit), label: unit || "no unit", side: n % 2 === 0 ? 3 : 1, stroke: text, grid: n === 0 ? grid : { show: false }, size: 64 }));
    const stepped = uPlot.paths.stepped({ align: 1 });
    const series = drawn.map(({ name, unit }, n) => ({ label: name, stroke: COLOURS[n], width: 1.5, scale: scale(unit), spanGaps: true, paths: stepped, points: { show: false } }));
    plot = new uPlot(
      {
        ...size(),
        legend: { show: false },
        cursor: { drag: { x: true, y: false, setScale: false } },
        scales: { x: { time: false, ...(Number.isFinite(from) ? { min: from, max: to } : {}) } },
        axes: [{ stroke: text, grid, label: "s", size: 40, labelSize: 18 }, ...axes],
        series: [{}, ...series],
        hooks: { setSelect: [zoomed], draw: [drawMarks], ready: [listen] },
      },
      values,
      area,
    );
  }

  function zoomed(self) {
    const { left, width } = self.select;
    if (width >= 4) show(self.posToVal(left, "x"), self.posToVal(left + width, "x"));
  }

  function listen(self) {
    self.over.addEventListener("click", (event) => mark(self.posToVal(event.offsetX, "x"), event.shiftKey));
    self.over.addEventListener("dblclick", () => show());
  }

  function drawMarks(self) {
    marks().forEach((time, n) => {
      if (time === null || time < self.scales.x.min || time > self.scales.x.max) return;
      const x = self.valToPos(time, "x", true);
      const { ctx, bbox } = self;
      const [name, colour] = MARKS[n];
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.lineWidth = devicePixelRatio;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.textAlign = "left";
      ctx.fillText(name, x + 4, bbox.top + 12 * devicePixelRatio);
      ctx.restore();
    });
  }

  function key(event) {
    if (!plot || event.target !== area || event.ctrlKey || event.metaKey || event.altKey) return;
    const { min, max } = plot.scales.x;
    const [span, middle] = [max - min, (min + max) / 2];
    const acts = {
      ArrowLeft: () => show(min - span / 4, max - span / 4),
      ArrowRight: () => show(min + span / 4, max + span / 4),
      "+": () => show(min + span / 4, max - span / 4),
      "-": () => show(min - span / 2, max + span / 2),
      0: () => show(),
      a: () => mark(middle, false),
      b: () => mark(middle, true),
    };
    const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  /** The plot with the names of its columns, as a PNG. */
  function picture() {
    const { canvas } = plot.ctx;
    const line = 18 * devicePixelRatio;
    const made = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height + line * (drawn.length + 0.5) });
    const context = made.getContext("2d");
    context.fillStyle = getComputedStyle(document.body).backgroundColor;
    context.fillRect(0, 0, made.width, made.height);
    context.drawImage(canvas, 0, 0);
    context.font = `${13 * devicePixelRatio}px sans-serif`;
    drawn.forEach(({ name }, n) => {
      context.fillStyle = COLOURS[n];
      context.fillText(name, line, canvas.height + line * (n + 0.7));
    });
    return new Promise((resolve) => made.toBlob(resolve));
  }

  const resized = new ResizeObserver(() => plot?.setSize(size()));
  resized.observe(area);
  area.addEventListener("keydown", key);

  return {
    draw(signals) {
      const range = plot && drawn.length > 0 ? [plot.scales.x.min, plot.scales.x.max] : [];
      drawn = signals;
      return show(...range);
    },
    whole: () => show(),
    redraw: () => plot?.redraw(),
    paint: () => plot?.redraw(),
    picture,
    drop() {
      turn++;
      resized.disconnect();
      area.removeEventListener("keydown", key);
      plot?.destroy();
      plot = null;
    },
  };
}
