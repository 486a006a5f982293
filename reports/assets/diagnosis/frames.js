// The list of frames: filtered, in pages, and with what each proves.
(() => {
  'use strict';
  const { data, element, view, several } = canvass;
  const PAGE = 200;
  const [NUMBER, NANOS, PLACE, CHANNEL, NODE, SERVICE, ID, DATA, TEXT] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
  const byId = (id) => document.getElementById(id);
  const [text, service, node, proof, inView] = ['frame-text', 'frame-service', 'frame-node', 'frame-proof', 'frame-view'].map(byId);
  const [body, shown, pageText, back, on] = ['frame-rows', 'frames-shown', 'frames-page', 'frames-back', 'frames-on'].map(byId);
  const { frames } = data;
  const table = body.closest('table');
  if (!several) table.classList.add('one-channel');
  const serviceOf = (frame) => data.services[frame[SERVICE]] ?? '';
  const searched = frames.map((frame) => `${frame[ID]} ${frame[DATA]} ${data.texts[frame[TEXT]]}`.toLowerCase());

  const unique = (place) => [...new Set(frames.map((frame) => frame[place]))];
  unique(SERVICE).filter((n) => n >= 0).sort((a, b) => a - b).forEach((n) => service.append(element('option', { value: n, textContent: data.services[n] })));
  unique(NODE).filter((n) => n !== null).sort((a, b) => a - b).forEach((n) => node.append(element('option', { value: n, textContent: n })));

  let chosen = [];
  let first = 0;
  let target = -1;

  const seconds = (nanos) => {
    const micros = Math.floor(Math.abs(nanos) / 1e3);
    const fraction = String(micros % 1e6).padStart(6, '0');
    return `${nanos < 0 ? '-' : ''}${Math.floor(micros / 1e6)}.${fraction}`;
  };

  const cell = (className, content) => element('td', { className, textContent: content });
  const row = (at) => {
    const frame = frames[at];
    const proofs = data.proofs[at] ?? [];
    const meaning = cell('text', data.texts[frame[TEXT]]);
    proofs.forEach((number) => {
      const finding = data.findings[number - 1];
      meaning.append(' ', element('a', { className: `proof ${finding.severity}`, href: `#finding-${number}`, textContent: finding.title }));
    });
    const made = element('tr', { id: `frame-${at}`, tabIndex: -1 },
      cell('number', seconds(frame[NANOS])), cell('number', frame[PLACE] || ''), cell('channel', data.channels[frame[CHANNEL]]),
      cell('', frame[NODE] ?? ''), cell('', serviceOf(frame)), cell('', frame[ID]), cell('bytes', frame[DATA]), meaning);
    if (proofs.length) made.classList.add('proves');
    if (at === target) made.classList.add('target');
    return made;
  };

  // What lies between two frames of the list that did not follow each other.
  const gap = (before, after) => {
    const [a, b] = [frames[before], frames[after]];
    if (a[NUMBER] && b[NUMBER] === a[NUMBER] + 1) return null;
    const count = a[NUMBER] && b[NUMBER] > a[NUMBER] ? String(b[NUMBER] - a[NUMBER] - 1) : 'some';
    const apart = Math.max(b[NANOS] - a[NANOS], 0) / 1e9;
    return element('tr', {}, element('td', { className: 'gap', colSpan: 8, textContent: `${count} frames in ${apart.toFixed(3)} s are not shown` }));
  };

  const draw = () => {
    const page = chosen.slice(first, first + PAGE);
    const isWhole = chosen.length === frames.length;
    const rows = page.flatMap((at, n) => {
      const before = n > 0 ? page[n - 1] : chosen[first - 1];
      return [isWhole && before !== undefined ? gap(before, at) : null, row(at)].filter(Boolean);
    });
    body.replaceChildren(...rows);
    if (!rows.length) body.append(element('tr', {}, element('td', { className: 'gap', colSpan: 8, textContent: 'No frame fits.' })));
    pageText.textContent = chosen.length ? `${first + 1} to ${first + page.length} of ${chosen.length}` : '';
    shown.textContent = isWhole ? '' : `${chosen.length} of ${frames.length}`;
    back.disabled = first === 0;
    on.disabled = first + PAGE >= chosen.length;
  };

  const filter = () => {
    const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (frame, at) => (service.value === '' || frame[SERVICE] === Number(service.value))
      && (node.value === '' || frame[NODE] === Number(node.value))
      && (!proof.checked || at in data.proofs)
      && (!inView.checked || (frame[NANOS] / 1e3 >= view.now.min && frame[NANOS] / 1e3 <= view.now.max))
      && words.every((word) => searched[at].includes(word));
    chosen = [...frames.keys()].filter((at) => fits(frames[at], at));
    first = 0;
    draw();
  };

  const turn = (by) => { first += by; draw(); table.scrollIntoView({ block: 'start' }); };
  back.addEventListener('click', () => turn(-PAGE));
  on.addEventListener('click', () => turn(PAGE));
  [text, service, node, proof, inView].forEach((input) => input.addEventListener('input', () => { target = -1; filter(); }));
  view.watch(() => { if (inView.checked) filter(); });

  // A link to a frame shows it among its neighbours, whatever was filtered.
  const reveal = () => {
    const wanted = /^#frame-(\d+)$/.exec(canvassPlace.hash);
    if (!wanted || !(Number(wanted[1]) < frames.length)) return;
    target = Number(wanted[1]);
    if (!chosen.includes(target) || chosen.length < frames.length) {
      [text.value, service.value, node.value, proof.checked, inView.checked] = ['', '', '', false, false];
      filter();
    }
    first = Math.floor(chosen.indexOf(target) / PAGE) * PAGE;
    draw();
    const made = byId(`frame-${target}`);
    made.scrollIntoView({ block: 'center', behavior: 'instant' });
    made.focus({ preventScroll: true });
  };
  canvassPlace.watch(reveal);
  // A link that is followed again changes nothing in the address.
  document.addEventListener('click', (event) => {
    if (!canvassPlace.isShown && event.target.closest?.('a.frame')?.hash === location.hash) reveal();
  });
  const begin = () => {
    filter();
    reveal();
  };
  // The list is far below what is seen first, unless a link leads to it.
  if (location.hash) begin();
  else addEventListener('load', () => setTimeout(begin));
})();
