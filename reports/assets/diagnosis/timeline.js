// What each node has said of its NMT state, with its silences, boot-ups and EMCY; findings as links above, and arrows from
// what broke to what follows from it.
(() => {
  'use strict';
  const { data, element, color, time, onChannel, view } = canvass;
  const ROW = 42;
  const AXIS = 24;
  // The middle of the links above a node's states.
  const PIN = 10;
  const STATES = { operational: '--good', 'pre-operational': '--accent', stopped: '--doubt', silent: '--bad', reset: '--faint' };
  const NAMES = { silent: 'silent (dropped out)', reset: 'reset by the master' };
  const SIGNS = { error: '✕', warning: '▲', info: '●' };
  const stateColor = (state) => STATES[state] ?? '--faint';

  const lanes = document.getElementById('lanes');
  const nodes = data.nodes.map((node) => ({ ...node, title: `Node ${node.id}`, whole: `Node ${node.id}${onChannel(node.channel)}` }));
  // What is about no node stands in a row of its channel.
  const findings = data.findings.map((finding, at) => ({ ...finding, number: at + 1 }));
  const isOf = (finding, node) => finding.node === node.id && finding.channel === node.channel;
  const others = findings.filter((finding) => !nodes.some((node) => isOf(finding, node)));
  const bus = { title: 'Bus', whole: 'Bus', states: [], boot_ups: [], emergencies: [], findings: others };
  const rows = [...(others.length ? [bus] : []), ...nodes.map((node) => ({ ...node, findings: findings.filter((finding) => isOf(finding, node)) }))];

  const names = lanes.appendChild(element('div', { className: 'names' }));
  const area = lanes.appendChild(element('div', { className: 'area' }));
  const canvas = area.appendChild(element('canvas', { role: 'img', ariaLabel: `NMT states of ${nodes.length} nodes over time; each node's table below lists them` }));
  const pins = area.appendChild(element('div', { className: 'pins' }));
  const tip = document.body.appendChild(element('div', { className: 'tip', hidden: true }));
  rows.forEach((row) => names.append(element('div', { className: 'name', textContent: row.title, title: `${row.whole} ${row.name ?? ''}` })));
  const height = rows.length * ROW + AXIS;

  const used = new Set(rows.flatMap((row) => row.states.map((span) => span[2])));
  const legend = document.getElementById('states');
  [...used].forEach((state) => {
    const swatch = element('span', { className: 'swatch' });
    swatch.style.setProperty('--state', `var(${stateColor(state)})`);
    swatch.classList.toggle('hollow', state === 'silent');
    legend.append(element('li', {}, swatch, NAMES[state] ?? state));
  });
  const marks = [['boot', 'boot-up'], ['emcy', 'EMCY'], ['gone', 'error gone (EMCY 00xxh)']];
  marks.forEach(([kind, text]) => legend.append(element('li', {}, element('span', { className: `mark ${kind}` }), text)));
  nodes.filter((node) => node.silent > 0)
    .forEach((node) => legend.append(element('li', {}, `${node.whole} was silent ${node.silent} times more, which are not drawn`)));

  const width = () => area.clientWidth;
  const toX = (micros) => ((micros - view.now.min) / (view.now.max - view.now.min)) * width();
  const isGone = (emergency) => emergency[1].startsWith('00');

  const segments = (row) => {
    const known = row.states.map(([from, to, state]) => ({ from, to, state }));
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
      const [silent, wide] = [state === 'silent', Math.max(right - left, 1)];
      context.fillStyle = color(stateColor(state), silent ? 0.12 : state === 'not known' ? 0.25 : 0.8);
      context.fillRect(left, top + 20, wide, 14);
      if (silent) {
        // A frame without anything in it.
        context.strokeStyle = color('--bad', 0.8);
        context.lineWidth = 1;
        context.setLineDash([4, 3]);
        context.strokeRect(left + 0.5, top + 20.5, Math.max(wide - 1, 0), 13);
        context.setLineDash([]);
      }
      if (right - left > 92) {
        context.fillStyle = color(silent ? '--bad' : '--card');
        context.fillText(state, Math.max(left, 0) + 7, top + 30.5);
      }
    }
    row.boot_ups.forEach((at) => {
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

  // Findings that would cover each other become one link to the worst of them.
  const pinGroups = (row) => {
    const visible = row.findings.map((finding) => ({ finding, x: toX(finding.t) })).filter(({ x }) => x >= -6 && x <= width() + 6);
    const groups = [];
    visible.sort((a, b) => a.x - b.x).forEach((pin) => {
      const last = groups[groups.length - 1];
      if (last && pin.x - last[0].x < 18) last.push(pin);
      else groups.push([pin]);
    });
    return groups.map((group) => ({ x: Math.min(Math.max(group[0].x, 9), width() - 9), findings: group.map(({ finding }) => finding) }));
  };

  const placePins = (groups) => {
    pins.replaceChildren();
    rows.forEach((row, n) => groups[n].forEach((group) => {
      const worst = group.findings.reduce((a, b) => (b.number < a.number ? b : a));
      const text = group.findings.map((finding) => `${time(finding.t)} s: ${finding.title}`).slice(0, 12).join('\n');
      const pin = element('a', {
        className: `pin ${worst.severity}`, href: `#finding-${worst.number}`, title: text,
        textContent: SIGNS[worst.severity] + (group.findings.length > 1 ? group.findings.length : ''),
      });
      pin.setAttribute('aria-label', `${row.whole}, ${text}`);
      pin.style.left = `${group.x}px`;
      pin.style.top = `${n * ROW + PIN - 8}px`;
      pins.append(pin);
    }));
  };

  // From the link of what broke to that of what follows from it, each once; within one link there is nothing to draw.
  const arrows = (groups) => {
    const places = new Map();
    groups.forEach((row, n) => row.forEach((group) => group.findings.forEach((finding) => {
      places.set(finding.number, { x: group.x, y: n * ROW + PIN, row: n });
    })));
    const drawn = new Map();
    findings.filter((finding) => finding.of).forEach((finding) => {
      const [from, to] = [places.get(finding.of), places.get(finding.number)];
      if (!from || !to || (from.x === to.x && from.y === to.y)) return;
      drawn.set([from.x, from.y, to.x, to.y].join(), { from, to, cause: finding.of, effect: finding.number });
    });
    return [...drawn.values()];
  };

  const head = (context, x, y, angle) => {
    context.save();
    context.translate(x, y);
    context.rotate(angle);
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(-7, -4);
    context.lineTo(-7, 4);
    context.closePath();
    context.fill();
    context.restore();
  };

  const drawArrow = (context, { from, to }) => {
    const within = from.row === to.row;
    const forth = within ? Math.sign(to.x - from.x) : Math.sign(to.y - from.y);
    context.beginPath();
    if (within) {
      context.moveTo(from.x + 10 * forth, from.y);
      context.lineTo(to.x - 16 * forth, to.y);
      context.stroke();
      head(context, to.x - 11 * forth, to.y, forth > 0 ? 0 : Math.PI);
      return;
    }
    const [begin, end] = [from.y + 10 * forth, to.y - 16 * forth];
    context.moveTo(from.x, begin);
    context.bezierCurveTo(from.x, (begin + end) / 2, to.x, (begin + end) / 2, to.x, end);
    context.stroke();
    head(context, to.x, to.y - 10 * forth, (forth * Math.PI) / 2);
  };

  let shown = [];
  const drawArrows = (context, groups) => {
    context.strokeStyle = color('--bad', 0.75);
    context.fillStyle = color('--bad', 0.75);
    context.lineWidth = 1.5;
    shown = arrows(groups);
    shown.forEach((arrow) => drawArrow(context, arrow));
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
    const groups = rows.map(pinGroups);
    drawArrows(context, groups);
    placePins(groups);
  };

  // What is below the pointer.
  const words = (row, at) => {
    const near = ((view.now.max - view.now.min) / width()) * 6;
    const segment = segments(row).find(({ from, to }) => at >= from && at < to);
    const lines = [`${row.whole}, ${time(at, view.now.max - view.now.min)} s`];
    if (segment) lines.push(`${segment.state} from ${time(segment.from)} to ${time(segment.to)} s`);
    row.emergencies.filter((sent) => Math.abs(sent[0] - at) <= near).slice(0, 4)
      .forEach(([, code, count]) => lines.push(`EMCY ${code}${count > 1 ? `, and ${count - 1} more` : ''}`));
    if (row.boot_ups.some((boot) => Math.abs(boot - at) <= near)) lines.push('boot-up');
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
  // What is drawn, for who wants to look at it.
  canvass.timeline = { rows, segments, arrows: () => shown };
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
