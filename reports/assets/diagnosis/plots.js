// Bus load and signals over time.
(() => {
  'use strict';
  const { data, element, color, time, number, onChannel, view } = canvass;
  const plots = new Set();
  canvass.plots = plots;
  const font = '11px system-ui, sans-serif';
  const narrow = matchMedia('(max-width: 40rem)');
  // As wide as the names of the timeline, so that times stand below each other.
  canvass.gutter = () => (narrow.matches ? 64 : 92);
  canvass.margin = 14;

  const axis = (more) => ({
    stroke: () => color('--soft'), font,
    grid: { stroke: () => color('--line'), width: 1 }, ticks: { stroke: () => color('--line'), width: 1, size: 4 }, ...more,
  });

  // `series`: lines beside the time, as uPlot takes them; `describe` says in words what stands at a place.
  const plot = ({ title, label, values, series, bands, height, describe }) => {
    const reading = element('output', { className: 'reading' });
    const figure = element('figure', { className: 'card plot' }, element('figcaption', {}, element('strong', { textContent: title }), reading));
    const box = figure.appendChild(element('div', { role: 'img', ariaLabel: label }));
    const shown = () => ({ min: view.now.min / 1e6, max: view.now.max / 1e6 });
    let made = null;
    const make = () => {
      const options = {
        width: Math.max(box.clientWidth, 200), height, padding: [10, canvass.margin, 0, 0], legend: { show: false }, bands,
        cursor: { y: false, drag: { x: false, y: false }, sync: { key: 'time' }, points: { size: 6 } },
        scales: { x: { time: false, auto: false, ...shown() }, y: { range: (u, min, max) => uPlot.rangeNum(min ?? 0, max ?? 1, 0.1, true) } },
        axes: [
          axis({ size: 28, values: (u, ticks) => ticks.map((tick) => `${time(tick * 1e6, (view.now.max - view.now.min))} s`), space: 90 }),
          axis({ size: canvass.gutter(), values: (u, ticks) => ticks.map(number) }),
        ],
        series: [{}, ...series],
        hooks: { setCursor: [(u) => { reading.textContent = u.cursor.idx === null ? '' : describe(u.cursor.idx, u.data[0][u.cursor.idx] * 1e6); }] },
      };
      made = new uPlot(options, values, box);
      view.control(made.over, box);
    };
    const entry = {
      figure,
      title,
      redraw: () => made?.redraw(),
      show: () => made?.setScale('x', shown()),
      range: () => made && { min: made.scales.x.min, max: made.scales.x.max },
      drop: () => { sized.disconnect(); made?.destroy(); plots.delete(entry); figure.remove(); },
    };
    const fit = () => {
      if (!box.isConnected) return;
      if (!made) make();
      else if (Math.abs(made.width - box.clientWidth) > 1) made.setSize({ width: Math.max(box.clientWidth, 200), height });
    };
    // Not at once: what is drawn changes sizes itself.
    const sized = new ResizeObserver(() => requestAnimationFrame(fit));
    plots.add(entry);
    return { ...entry, attach: (parent) => { parent.append(figure); sized.observe(box); return entry; } };
  };

  const stepped = uPlot.paths.stepped({ align: 1 });

  const load = (bus) => {
    // The last bin ends somewhere.
    const again = (list) => [...list, list[list.length - 1]];
    const at = [...bus.mean.keys(), bus.mean.length].map((n) => Math.min(bus.start + n * bus.width, Math.max(data.span, bus.start + 1)) / 1e6);
    for (let n = 1; n < at.length; n++) at[n] = Math.max(at[n], at[n - 1]);
    const [mean, least, most] = [bus.mean, bus.least, bus.most].map(again);
    const peak = most.reduce((a, b) => Math.max(a, b), 0);
    const line = (name, alpha) => ({ stroke: () => color(name, alpha), paths: stepped, points: { show: false } });
    plot({
      title: `${data.channels[bus.channel]}: load in ${bus.unit}`,
      label: `Bus load of ${data.channels[bus.channel]} over time, at most ${peak} ${bus.unit}`,
      values: [at, most, least, mean], height: 190,
      bands: [{ series: [1, 2], fill: () => color('--accent', 0.22) }],
      series: [line('--accent', 0.35), line('--accent', 0.35), { ...line('--accent', 1), width: 1.5 }],
      describe: (n, t) => `${time(t, data.span)} s: ${number(mean[n])} ${bus.unit}, from ${number(least[n])} to ${number(most[n])}`,
    }).attach(document.getElementById('load-plots'));
  };
  data.buses.forEach(load);

  const HUES = ['--accent', '--good', '--odd', '--doubt', '--bad'];
  const place = document.getElementById('signal-plots');
  const signals = data.signals.map((signal, at) => {
    const unit = signal.unit ? ` [${signal.unit}]` : '';
    return { ...signal, at, name: `Node ${signal.node}${onChannel(signal.channel)}: ${signal.label}${unit}`, entry: null };
  });
  const draw = (signal) => {
    let now = 0;
    const times = signal.t.map((step) => (now += step) / 1e6);
    const range = signal.v.reduce(([least, most], v) => [Math.min(least, v), Math.max(most, v)], [Infinity, -Infinity]);
    const hue = HUES[signal.at % HUES.length];
    signal.entry = plot({
      title: signal.name,
      label: `${signal.name} over time, from ${number(range[0])} to ${number(range[1])}`,
      values: [times, signal.v], height: 150,
      series: [{ stroke: () => color(hue), width: 1.5, paths: stepped, points: { size: 4 } }],
      describe: (n, t) => `${time(t, Math.min(data.span, 1e6))} s: ${number(signal.v[n])} ${signal.unit}`,
    }).attach(place);
    // In the order of the list, whenever it was chosen.
    signals.filter((other) => other.entry).forEach((other) => place.append(other.entry.figure));
  };
  const choice = document.getElementById('signal-choice');
  // At first one of each node, as far as there are not too many.
  const isFirst = (signal) => signals.find((other) => other.node === signal.node && other.channel === signal.channel) === signal;
  const foremost = new Set([...new Set([...signals.filter(isFirst), ...signals])].slice(0, 4));
  signals.forEach((signal) => {
    const box = element('input', { type: 'checkbox', checked: foremost.has(signal) });
    box.addEventListener('change', () => {
      if (box.checked) draw(signal);
      else { signal.entry.drop(); signal.entry = null; }
    });
    choice.append(element('label', {}, box, element('span', { textContent: signal.name })));
    if (box.checked) draw(signal);
  });

  view.watch(() => plots.forEach((entry) => entry.show()));
  addEventListener('themechange', () => plots.forEach((entry) => entry.redraw()));
})();
