// The time that the timeline and all plots show: one for all of them, in microseconds since the first frame; and the
// cursor, which a click sets in all of them.
canvass.view = (() => {
  'use strict';
  const { data, element, time } = canvass;
  const SHORTEST = 20;
  const room = Math.max(data.span * 0.01, 50);
  const all = { min: -room, max: data.span + room };
  const view = { min: all.min, max: all.max };
  const watchers = [];
  const pointed = [];
  const cursors = [];
  let cursor = null;

  // Shows the cursor everywhere.
  const mark = () => {
    const at = cursor === null ? -1 : (cursor - view.min) / (view.max - view.min);
    cursors.forEach((line) => {
      line.hidden = at < 0 || at > 1;
      line.style.left = `${at * 100}%`;
    });
  };
  const point = (micros) => { cursor = micros; mark(); };
  const pointTo = (micros) => {
    point(Math.min(Math.max(micros, 0), data.span));
    pointed.forEach((watcher) => watcher(cursor));
  };

  const set = (min, max) => {
    const span = Math.min(Math.max(max - min, SHORTEST), all.max - all.min);
    const middle = (min + max) / 2;
    view.min = Math.min(Math.max(middle - span / 2, all.min), all.max - span);
    view.max = view.min + span;
    watchers.forEach((watcher) => watcher(view));
    mark();
    show();
  };
  const zoom = (factor, at = (view.min + view.max) / 2) => set(at - (at - view.min) * factor, at + (view.max - at) * factor);
  const move = (part) => { const by = (view.max - view.min) * part; set(view.min + by, view.max + by); };
  const whole = () => set(all.min, all.max);
  const isWhole = () => view.max - view.min >= all.max - all.min;

  const acts = { in: () => zoom(0.5), out: () => zoom(2), back: () => move(-0.4), on: () => move(0.4), all: whole };
  const buttons = [...document.querySelectorAll('[data-view]')];
  const ranges = [...document.querySelectorAll('.controls .range')];
  buttons.forEach((button) => button.addEventListener('click', () => acts[button.dataset.view]()));
  const show = () => {
    buttons.forEach((button) => { button.disabled = isWhole() && button.dataset.view !== 'in'; });
    const span = view.max - view.min;
    const text = isWhole() ? '' : `${time(Math.max(view.min, 0), span)} to ${time(Math.min(view.max, data.span), span)} s`;
    ranges.forEach((range) => { range.textContent = text; });
  };

  // Lets an element that shows this time be dragged, wheeled, pinched and moved by keys.
  const keys = { ArrowLeft: acts.back, ArrowRight: acts.on, '+': acts.in, '=': acts.in, '-': acts.out, 0: whole, Home: whole };
  const control = (surface, focusable = surface) => {
    const selection = surface.appendChild(element('div', { className: 'selection', hidden: true }));
    cursors.push(surface.appendChild(element('div', { className: 'cursor', hidden: true })));
    mark();
    const fingers = new Map();
    let drag = null;
    const at = (x) => {
      const box = surface.getBoundingClientRect();
      return view.min + ((x - box.left) / box.width) * (view.max - view.min);
    };
    const pan = (by) => set(view.min - by, view.max - by);
    focusable.tabIndex = 0;
    focusable.addEventListener('keydown', (event) => {
      const act = event.ctrlKey || event.metaKey || event.altKey ? null : keys[event.key];
      if (act) { event.preventDefault(); act(); }
    });
    surface.addEventListener('dblclick', whole);
    surface.addEventListener('wheel', (event) => {
      if (event.ctrlKey || event.metaKey) zoom(2 ** (event.deltaY / 200), at(event.clientX));
      else if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) move(event.deltaX / 800);
      else return;
      event.preventDefault();
    }, { passive: false });
    surface.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || event.target.closest('a')) return;
      surface.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event.clientX);
      const pans = event.pointerType === 'touch' || event.shiftKey;
      drag = fingers.size === 1 ? { from: event.clientX, at: at(event.clientX), pans } : null;
      if (event.pointerType !== 'touch') event.preventDefault();
      focusable.focus({ preventScroll: true });
    });
    surface.addEventListener('pointermove', (event) => {
      if (!fingers.has(event.pointerId)) return;
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()];
        fingers.set(event.pointerId, event.clientX);
        const [c, d] = [...fingers.values()];
        const middle = at((a + b) / 2);
        if (Math.abs(c - d) > 8) zoom(Math.abs(a - b) / Math.abs(c - d), middle);
        pan(at((c + d) / 2) - middle);
        return;
      }
      fingers.set(event.pointerId, event.clientX);
      if (!drag) return;
      if (drag.pans) { pan(at(event.clientX) - drag.at); return; }
      const left = surface.getBoundingClientRect().left;
      const [first, last] = [drag.from, event.clientX].sort((a, b) => a - b);
      selection.hidden = last - first < 4;
      selection.style.left = `${first - left}px`;
      selection.style.width = `${last - first}px`;
    });
    const end = (event) => {
      fingers.delete(event.pointerId);
      if (drag && !drag.pans && !selection.hidden && event.type === 'pointerup') {
        const [first, last] = [drag.at, at(event.clientX)].sort((a, b) => a - b);
        set(first, last);
      } else if (drag && event.type === 'pointerup' && Math.abs(event.clientX - drag.from) < 4) pointTo(at(event.clientX));
      selection.hidden = true;
      drag = null;
    };
    surface.addEventListener('pointerup', end);
    surface.addEventListener('pointercancel', end);
  };

  show();
  return {
    now: view, all, set, zoom, move, whole, isWhole, control, point, pointTo,
    watch: (watcher) => watchers.push(watcher), watchPoint: (watcher) => pointed.push(watcher),
  };
})();
