// Objects are shown or hidden whole, by what stands in any of their rows.
(() => {
  const objects = [...document.querySelectorAll('table.objects tbody')];
  const areas = [...document.querySelectorAll('.area')];
  const filter = document.getElementById('filter');
  const shown = document.getElementById('shown');
  const texts = objects.map((object) => object.textContent.toLowerCase());
  const update = () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    objects.forEach((object, at) => {
      object.hidden = !words.every((word) => texts[at].includes(word));
      count += object.hidden ? 0 : 1;
    });
    areas.forEach((area) => { area.hidden = !area.querySelector('tbody:not([hidden])'); });
    shown.textContent = count === objects.length ? '' : count + ' of ' + objects.length;
  };
  filter.addEventListener('input', update);
  // A link to an object that is hidden shows all again.
  canvassPlace.watch(() => {
    const target = document.getElementById(decodeURIComponent(canvassPlace.hash.slice(1)));
    if (target && target.hidden) {
      filter.value = '';
      update();
      target.scrollIntoView();
    }
  });
})();
