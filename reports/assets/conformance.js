(() => {
  const cases = [...document.querySelectorAll('.finding')];
  const tiles = [...document.querySelectorAll('.tile')];
  const filter = document.getElementById('filter');
  const shown = document.getElementById('shown');
  const texts = cases.map((c) => c.querySelector('summary').textContent.toLowerCase() + ' '
    + [...c.querySelectorAll('.body > p, .reason')].map((e) => e.textContent.toLowerCase()).join(' '));
  const update = () => {
    const kinds = tiles.filter((t) => t.getAttribute('aria-pressed') === 'true').map((t) => t.dataset.kind);
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    cases.forEach((c, i) => {
      const fits = (kinds.length === 0 || kinds.includes(c.dataset.kind)) && words.every((w) => texts[i].includes(w));
      c.hidden = !fits;
      count += fits ? 1 : 0;
    });
    shown.textContent = count === cases.length ? '' : count + ' of ' + cases.length;
  };
  tiles.forEach((t) => t.addEventListener('click', () => {
    const on = t.getAttribute('aria-pressed') !== 'true';
    t.setAttribute('aria-pressed', on ? 'true' : 'false');
    update();
    if (on) { document.getElementById('cases').scrollIntoView(); }
  }));
  filter.addEventListener('input', update);
  const reveal = () => {
    const target = canvassPlace.hash && document.getElementById(decodeURIComponent(canvassPlace.hash.slice(1)));
    for (let at = target; at; at = at.parentElement) {
      if (at.tagName === 'DETAILS') { at.hidden = false; at.open = true; }
    }
    if (target && target.tagName === 'TR') { target.scrollIntoView({ block: 'center' }); }
  };
  canvassPlace.watch(reveal);
  reveal();
  let closed = [];
  addEventListener('beforeprint', () => {
    closed = cases.filter((c) => !c.open && !c.hidden);
    closed.forEach((c) => { c.open = true; });
  });
  addEventListener('afterprint', () => closed.forEach((c) => { c.open = false; }));
})();
