// Times over the releases.
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  const choice = document.getElementById('case');
  const box = document.getElementById('plots');
  // As the browser shows it, light or dark.
  const probe = document.body.appendChild(document.createElement('span'));
  probe.hidden = true;
  const color = (name) => {
    probe.style.color = `var(${name})`;
    return getComputedStyle(probe).color;
  };
  const at = data.releases.map((_, n) => n);
  const plot = (title, values) => {
    const figure = document.createElement('figure');
    figure.className = 'card plot';
    const caption = figure.appendChild(document.createElement('figcaption'));
    caption.textContent = title;
    const place = figure.appendChild(document.createElement('div'));
    box.append(figure);
    const axis = { stroke: () => color('--soft'), grid: { stroke: () => color('--line'), width: 1 } };
    new uPlot({
      width: Math.max(place.clientWidth, 200), height: 180, legend: { show: false },
      scales: { x: { time: false, range: [-0.5, at.length - 0.5] } },
      axes: [
        { ...axis, splits: () => at, values: (u, ticks) => ticks.map((n) => data.releases[n] ?? '') },
        { ...axis, size: 70 },
      ],
      series: [{}, { stroke: () => color('--accent'), width: 2, points: { show: true, size: 6 } }],
    }, [at, values], place);
  };
  const show = () => {
    const row = data.cases[choice.value];
    box.replaceChildren();
    if (!row) return;
    plot('Duration on the bus [ms]', row.duration);
    row.measured.forEach(({ name, values }) => plot(`${name} [ms]`, values));
  };
  data.cases.forEach((row, n) => {
    const option = document.createElement('option');
    option.value = n;
    option.textContent = row.id;
    choice.append(option);
  });
  // One that was measured tells more.
  const measured = data.cases.findIndex((row) => row.measured.length > 0);
  choice.value = Math.max(measured, 0);
  choice.addEventListener('change', show);
  show();
})();
