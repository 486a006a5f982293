// The findings: filtered by severity and words, shown in the plots; and what paper needs.
(() => {
  'use strict';
  const { data, view } = canvass;
  const findings = [...document.querySelectorAll('.finding')];
  const texts = findings.map((finding) => finding.textContent.toLowerCase());
  const tiles = [...document.querySelectorAll('.tile')];
  const input = document.getElementById('finding-text');
  const shown = document.getElementById('findings-shown');

  const filter = () => {
    const severities = tiles.filter((tile) => tile.getAttribute('aria-pressed') === 'true').map((tile) => tile.dataset.severity);
    const words = input ? input.value.toLowerCase().split(/\s+/).filter(Boolean) : [];
    let count = 0;
    findings.forEach((finding, at) => {
      const fits = (!severities.length || severities.includes(finding.dataset.severity)) && words.every((word) => texts[at].includes(word));
      finding.hidden = !fits;
      count += fits ? 1 : 0;
    });
    if (shown) shown.textContent = count === findings.length ? '' : `${count} of ${findings.length}`;
  };
  tiles.forEach((tile) => tile.addEventListener('click', () => {
    tile.setAttribute('aria-pressed', String(tile.getAttribute('aria-pressed') !== 'true'));
    filter();
  }));
  input?.addEventListener('input', filter);

  // A link to a finding that is filtered out shows all again.
  const reveal = () => {
    const finding = /^#finding-\d+$/.test(canvassPlace.hash) ? document.getElementById(canvassPlace.hash.slice(1)) : null;
    if (!finding) return;
    if (finding.hidden) {
      tiles.forEach((tile) => tile.setAttribute('aria-pressed', 'false'));
      if (input) input.value = '';
      filter();
      finding.scrollIntoView();
    }
    finding.focus({ preventScroll: true });
  };
  canvassPlace.watch(reveal);
  reveal();

  document.querySelectorAll('button[data-from]').forEach((button) => button.addEventListener('click', () => {
    const [from, to] = [Number(button.dataset.from), Number(button.dataset.to)];
    // One that goes on and on is shown as it begins.
    const long = Math.max(Math.min((to - from) * 1.3, data.span / 4), data.span / 200, 1000);
    view.set(from - long * 0.4, from + long * 0.8);
    view.pointTo(from);
    document.getElementById('timeline').scrollIntoView();
  }));

  // On paper everything is light and open.
  let before = null;
  let closed = [];
  addEventListener('beforeprint', () => {
    before = document.documentElement.dataset.theme ?? null;
    document.documentElement.dataset.theme = 'light';
    closed = [...document.querySelectorAll('details.node:not([open])')];
    closed.forEach((details) => { details.open = true; });
    dispatchEvent(new Event('themechange'));
  });
  addEventListener('afterprint', () => {
    if (before === null) delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = before;
    closed.forEach((details) => { details.open = false; });
    dispatchEvent(new Event('themechange'));
  });
})();
