// Values over days, months and releases.
(() => {
  'use strict';
  const box = document.getElementById('plots');
  // As the browser shows it, light or dark.
  const probe = document.body.appendChild(document.createElement('span'));
  probe.hidden = true;
  const color = (name) => {
    probe.style.color = `var(${name})`;
    return getComputedStyle(probe).color;
  };
  const colors = ['--accent', '--bad', '--good', '--doubt', '--odd', '--faint'];
  // All places are there before the first plot takes its width.
  const places = JSON.parse(document.getElementById('data').textContent).map(({ title, ...plot }) => {
    const figure = document.createElement('figure');
    figure.className = 'card plot';
    const caption = figure.appendChild(document.createElement('figcaption'));
    caption.textContent = title;
    const place = figure.appendChild(document.createElement('div'));
    box.append(figure);
    return { place, ...plot };
  });
  places.forEach(({ place, labels, lines }) => {
    const at = labels.map((_, n) => n);
    const axis = { stroke: () => color('--soft'), grid: { stroke: () => color('--line'), width: 1 } };
    new uPlot({
      width: Math.max(place.clientWidth, 200), height: 200, legend: { show: lines.length > 1 },
      scales: { x: { time: false, range: [-0.5, at.length - 0.5] }, y: { range: (u, low, high) => [0, high > 0 ? high * 1.1 : 1] } },
      axes: [
        { ...axis, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000], space: 80, values: (u, ticks) => ticks.map((n) => labels[n] ?? '') },
        { ...axis, size: 70 },
      ],
      series: [{ label: '', value: (u, n) => labels[n] ?? '' }].concat(lines.map(({ name }, n) => ({
        label: name, stroke: () => color(colors[n % colors.length]), width: 2, spanGaps: true, points: { show: true, size: 6 },
      }))),
    }, [at, ...lines.map(({ values }) => values)], place);
  });
})();
