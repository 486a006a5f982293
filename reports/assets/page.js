// Where in the page the reader is: the address after the #. Where another page shows this one, its document has no origin, and
// browsers follow no link in it: links are then followed here.
const canvassPlace = (() => {
  const isShown = parent !== window;
  const watchers = [];
  let hash = location.hash;
  const tell = () => watchers.forEach((watcher) => watcher());
  const show = (target) => {
    const { top, bottom } = target.getBoundingClientRect();
    if (bottom < 0 || top > innerHeight - 40 || (top === 0 && bottom === 0)) target.scrollIntoView();
  };
  if (isShown) {
    document.addEventListener('click', (event) => {
      const link = event.target.closest?.('a[href^="#"]');
      if (!link || event.defaultPrevented) return;
      event.preventDefault();
      hash = link.getAttribute('href');
      const target = document.getElementById(decodeURIComponent(hash.slice(1)));
      target?.scrollIntoView();
      tell();
      // What was closed or filtered out has its place only now.
      if (target) show(target);
      if (target?.tabIndex >= 0 || target?.hasAttribute('tabindex')) target.focus({ preventScroll: true });
    });
  } else {
    addEventListener('hashchange', tell);
  }
  return { get hash() { return isShown ? hash : location.hash; }, isShown, watch: (watcher) => watchers.push(watcher) };
})();

// The colours of the page: the system's, or what the reader chose before.
(() => {
  const key = 'canvass-theme';
  const choices = [...document.querySelectorAll('.themes input')];
  const choose = (theme) => {
    if (theme) document.documentElement.dataset.theme = theme;
    else delete document.documentElement.dataset.theme;
    choices.forEach((choice) => { choice.checked = choice.value === theme; });
    dispatchEvent(new Event('themechange'));
  };
  // Where storage is forbidden, the choice lasts as long as the page.
  let chosen = '';
  try { chosen = localStorage.getItem(key) || ''; } catch { /* forbidden */ }
  if (chosen) choose(chosen);
  choices.forEach((choice) => choice.addEventListener('change', () => {
    choose(choice.value);
    try { localStorage.setItem(key, choice.value); } catch { /* forbidden */ }
  }));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => dispatchEvent(new Event('themechange')));

  // Where another page shows this one, it has the colours of that page.
  if (parent !== window) {
    document.querySelectorAll('.themes').forEach((themes) => { themes.hidden = true; });
    addEventListener('message', ({ source, data }) => {
      if (source === parent && ['', 'light', 'dark'].includes(data?.theme)) choose(data.theme);
    });
  }

  // The section that is being read is marked in the navigation.
  const links = [...document.querySelectorAll('nav.sections a')];
  const sections = links.map((link) => document.getElementById(link.hash.slice(1)));
  let waiting = false;
  const mark = () => {
    waiting = false;
    const at = sections.findLastIndex((section) => section && section.getBoundingClientRect().top < innerHeight / 3);
    links.forEach((link, n) => {
      if (n === at) link.setAttribute('aria-current', 'true');
      else link.removeAttribute('aria-current');
    });
  };
  const later = () => { if (!waiting) { waiting = true; requestAnimationFrame(mark); } };
  if (links.length) { addEventListener('scroll', later, { passive: true }); later(); }
})();
