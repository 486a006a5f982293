// The NMT states of each node, with boot-ups and EMCY, and findings as links above them.
(() => {
  'use strict';
  const { data, element, color, time, onChannel, view } = canvass;
  const ROW = 42;
  const AXIS = 24;
  const STATES = { operational: '--good', 'pre-operational': '--accent', stopped: '--doubt', 'boot-up': '--odd' };
  const SIGNS = { error: '✕', warning: '▲', info: '●' };
  const stateColor = (state) => STATES[state] ?? '--faint';

  const lanes = document.getElementById('lanes');
  const nodes = data.nodes.map((node) => ({ ...node, title: `Node ${node.id}`, whole: `Node ${node.id}${onChannel(node.channel)}` }));
  // What is about no node stands in a row of its channel.
  const findings = data.findings.map((finding, at) => ({ ...finding, number: at + 1 }));
  const isOf = (finding, node) => finding.node === node.id && finding.channel === node.channel;
  const others = findings.filter((finding) => !nodes.some((node) => isOf(finding, node)));
  const bus = { title: 'Bus', whole: 'Bus', states: [], emergencies: [], findings: others };
  const rows = [...(others.length ? [bus] : []), ...nodes.map((node) => ({ ...node, findings: findings.filter((finding) => isOf(finding, node)) }))];

  const names = lanes.appendChild(element('div', { className: 'names' }));
  const area = lanes.appendChild(element('div', { className: 'area' }));
  const canvas = area.appendChild(element('canvas', { role: 'img', ariaLabel: `NMT states of ${nodes.length} nodes over time; each node's table below lists them` }));
  const pins = area.appendChild(element('div', { className: 'pins' }));
  const tip = document.body.appendChild(element('div', { className: 'tip', hidden: true }));
  rows.forEach((row) => names.append(element('div', { className: 'name', textContent: row.title, title: `${row.whole} ${row.name ?? ''}` })));
  const height = rows.length * ROW + AXIS;

  const used = new Set(rows.flatMap((row) => row.states.map((change) => change[1])));
  const legend = document.getElementById('states');
  [...used].forEach((state) => {
    const swatch = element('span', { className: 'swatch' });
    swatch.style.setProperty('--state', `var(${stateColor(state)})`);
    legend.append(element('li', {}, swatch, state));
  });
  const marks = [['boot', 'boot-up'], ['emcy', 'EMCY'], ['gone', 'error gone (EMCY 00xxh)']];
  marks.forEach(([kind, text]) => legend.append(element('li', {}, element('span', { className: `mark ${kind}` }), text)));

  const width = () => area.clientWidth;
  const toX = (micros) => ((micros - view.now.min) / (view.now.max - view.now.min)) * width();
  const isGone = (emergency) => emergency[1].startsWith('00');

  const segments = (row) => {
    const known = row.states.map(([at, state], n) => ({ from: at, to: row.states[n + 1]?.[0] ?? Math.max(row.last, at), state }));
    const first = known[0]?.from ?? row.last;
    return first > row.first ? [{ from: row.first, to: first, state: 'not known' }, ...known] : known;
  };

  const dot = (context, x, y, gone) => {
    context.beginPath();
    context.arc(x, y, 4, 0, 7);
    context.fillStyle = color(gone ? '--card' : '--bad');
    context.strokeStyle = color(gone ? '--good' : '--card');
    context.lineWidth = gone ? 2 : 1;
    context.fill();
    context.stroke();
  };

  const drawRow = (context, row, n) => {
    const top = n * ROW;
    const most = width();
    context.fillStyle = color('--line');
    context.fillRect(0, top + ROW - 1, most, 1);
    let drawn = -Infinity;
    for (const { from, to, state } of segments(row)) {
      const [left, right] = [Math.max(toX(from), -2), Math.min(toX(to), most + 2)];
      // Thousands of changes within a pixel look like one.
      if (right < 0 || left > most || right < drawn) continue;
      drawn = Math.max(right, left + 1);
      context.fillStyle = color(stateColor(state), state === 'not known' ? 0.25 : 0.8);
      context.fillRect(left, top + 20, Math.max(right - left, 1), 14);
      if (right - left > 92) {
        context.fillStyle = color('--card');
        context.fillText(state, Math.max(left, 0) + 7, top + 30.5);
      }
    }
    row.states.filter((change) => change[2]).forEach(([at]) => {
      const x = toX(at);
      if (x < -9 || x > most + 9) return;
      context.beginPath();
      context.moveTo(x, top + 30);
      context.lineTo(x + 5, top + 40);
      context.lineTo(x - 5, top + 40);
      context.closePath();
      context.fillStyle = color('--odd');
      context.strokeStyle = color('--card');
      context.lineWidth = 1;
      context.fill();
      context.stroke();
    });
    row.emergencies.forEach((emergency) => {
      const x = toX(emergency[0]);
      if (x > -9 && x < most + 9) dot(context, x, top + 27, isGone(emergency));
    });
  };

  const drawAxis = (context) => {
    const span = view.now.max - view.now.min;
    const wanted = span / Math.max(width() / 110, 1);
    const power = 10 ** Math.floor(Math.log10(wanted));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= wanted) ?? wanted;
    context.textAlign = 'center';
    for (let at = Math.ceil(view.now.min / step) * step; at <= view.now.max; at += step) {
      const x = toX(at);
      context.fillStyle = color('--line', 0.7);
      context.fillRect(x, 0, 1, height - AXIS + 4);
      context.fillStyle = color('--soft');
      if (x > 24 && x < width() - 24) context.fillText(`${time(at, span)} s`, x, height - 7);
    }
    context.textAlign = 'left';
  };

  // From what broke to what followed from it.
  const rowOf = (finding) => rows.findIndex((row) => row.findings.some((own) => own.number === finding.number));
  const drawArrows = (context) => {
    context.strokeStyle = color('--bad', 0.75);
    context.fillStyle = color('--bad', 0.75);
    context.lineWidth = 1.5;
    findings.filter((finding) => finding.of).forEach((finding) => {
      const cause = findings[finding.of - 1];
      const [from, to] = [cause && rowOf(cause), rowOf(finding)];
      if (!cause || from < 0 || to < 0 || from === to) return;
      const [x, y, left, top] = [toX(cause.t), from * ROW + 10, toX(finding.t), to * ROW + 10];
      if (Math.max(x, left) < -9 || Math.min(x, left) > width() + 9) return;
      const down = top > y ? 1 : -1;
      context.beginPath();
      context.moveTo(x, y + 8 * down);
      context.bezierCurveTo(x, (y + top) / 2, left, (y + top) / 2, left, top - 10 * down);
      context.stroke();
      context.beginPath();
      context.moveTo(left, top - 6 * down);
      context.lineTo(left - 4, top - 13 * down);
      context.lineTo(left + 4, top - 13 * down);
      context.closePath();
      context.fill();
    });
  };

  // Findings that would cover each other become one link to the worst of them.
  const placePins = () => {
    pins.replaceChildren();
    rows.forEach((row, n) => {
      const visible = row.findings.map((finding) => ({ finding, x: toX(finding.t) })).filter(({ x }) => x >= -6 && x <= width() + 6);
      const groups = [];
      visible.sort((a, b) => a.x - b.x).forEach((pin) => {
        const last = groups[groups.length - 1];
        if (last && pin.x - last[0].x < 18) last.push(pin);
        else groups.push([pin]);
      });
      groups.forEach((group) => {
        const worst = group.reduce((a, b) => (b.finding.number < a.finding.number ? b : a)).finding;
        const text = group.map(({ finding }) => `${time(finding.t)} s: ${finding.title}`).slice(0, 12).join('\n');
        const pin = element('a', {
          className: `pin ${worst.severity}`, href: `#finding-${worst.number}`, title: text,
          textContent: SIGNS[worst.severity] + (group.length > 1 ? group.length : ''),
        });
        pin.setAttribute('aria-label', `${row.whole}, ${text}`);
        pin.style.left = `${Math.min(Math.max(group[0].x, 9), width() - 9)}px`;
        pin.style.top = `${n * ROW + 2}px`;
        pins.append(pin);
      });
    });
  };

  const draw = () => {
    lanes.style.setProperty('--gutter', `${canvass.gutter()}px`);
    const scale = devicePixelRatio || 1;
    canvas.width = Math.round(width() * scale);
    canvas.height = Math.round(height * scale);
    canvas.style.height = `${height}px`;
    const context = canvas.getContext('2d');
    context.scale(scale, scale);
    context.font = '11px system-ui, sans-serif';
    drawAxis(context);
    rows.forEach((row, n) => drawRow(context, row, n));
    drawArrows(context);
    placePins();
  };

  // What is below the pointer.
  const words = (row, at) => {
    const near = ((view.now.max - view.now.min) / width()) * 6;
    const segment = segments(row).find(({ from, to }) => at >= from && at < to);
    const lines = [`${row.whole}, ${time(at, view.now.max - view.now.min)} s`];
    if (segment) lines.push(`${segment.state} from ${time(segment.from)} to ${time(segment.to)} s`);
    row.emergencies.filter((sent) => Math.abs(sent[0] - at) <= near).slice(0, 4)
      .forEach(([, code, count]) => lines.push(`EMCY ${code}${count > 1 ? `, and ${count - 1} more` : ''}`));
    if (row.states.some((change) => change[2] && Math.abs(change[0] - at) <= near)) lines.push('boot-up');
    return lines.join('\n');
  };
  area.addEventListener('pointermove', (event) => {
    const box = area.getBoundingClientRect();
    const row = rows[Math.floor((event.clientY - box.top) / ROW)];
    tip.hidden = !row || row === bus || event.pointerType === 'touch' || event.target.closest('a') !== null;
    if (tip.hidden) return;
    tip.textContent = words(row, view.now.min + ((event.clientX - box.left) / box.width) * (view.now.max - view.now.min));
    tip.style.left = `${Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8)}px`;
    tip.style.top = `${event.clientY + 16}px`;
  });
  area.addEventListener('pointerleave', () => { tip.hidden = true; });

  if (rows.length === 0) { lanes.hidden = true; return; }
  view.control(area);
  area.setAttribute('role', 'group');
  area.setAttribute('aria-label', 'Timeline of NMT states');
  // Once for each picture of the screen, however often something moves.
  let waiting = false;
  const later = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  };
  view.watch(later);
  addEventListener('themechange', draw);
  new ResizeObserver(later).observe(area);
})();
