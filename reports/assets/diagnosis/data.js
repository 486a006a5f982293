// What was collected, and small helpers that all scripts of this page share. Whatever came off the bus is put into the
// page as text (`textContent`), never as markup.
const canvass = (() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);

  const element = (tag, properties = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
      if (name in made) made[name] = value;
      else made.setAttribute(name, value);
    }
    made.append(...children.filter((child) => child !== null && child !== undefined));
    return made;
  };

  // A colour of the style sheet as the theme makes it. To ask the browser takes long: once for each.
  const probe = document.body.appendChild(element('span', { hidden: true }));
  const colors = new Map();
  const color = (name, alpha = 1) => {
    const key = `color-mix(in srgb, var(${name}) ${alpha * 100}%, transparent)`;
    if (!colors.has(key)) {
      probe.style.color = key;
      colors.set(key, getComputedStyle(probe).color);
    }
    return colors.get(key);
  };
  addEventListener('themechange', () => colors.clear());

  // A time in microseconds as seconds; over `span`, only the digits that differ are of interest.
  const time = (micros, span = 0) => {
    const digits = span > 100e6 ? 0 : span > 10e6 ? 1 : span > 1e6 ? 2 : span > 1e5 ? 3 : span > 1e3 ? 5 : 6;
    return (micros / 1e6).toFixed(digits);
  };

  const number = (value) => {
    if (!Number.isFinite(value)) return '';
    const size = Math.abs(value);
    if (size >= 1e15 || (size > 0 && size < 1e-4)) return value.toExponential(3);
    return String(Number.isInteger(value) ? value : Number(value.toPrecision(7)));
  };

  const several = data.channels.length > 1;
  const onChannel = (channel) => (several ? ` on ${data.channels[channel]}` : '');

  return { data, element, color, time, number, several, onChannel };
})();
