// Where another page shows this one, both point at the same time. What is sent and heard is a number of seconds.
(() => {
  'use strict';
  const { data, view } = canvass;
  const NANOS = 1;
  const tell = (seconds) => { if (parent !== window) parent.postMessage({ cursor: seconds }, '*'); };
  view.watchPoint((micros) => tell(micros / 1e6));
  document.getElementById('frame-rows').addEventListener('click', (event) => {
    const row = /^frame-(\d+)$/.exec(event.target.closest('tr')?.id ?? '');
    const frame = row && !event.target.closest('a') ? data.frames[Number(row[1])] : null;
    if (!frame) return;
    view.point(frame[NANOS] / 1e3);
    tell(frame[NANOS] / 1e9);
  });
  // The frame of a finding is the frame at which both point.
  canvassPlace.watch(() => {
    const row = /^#frame-(\d+)$/.exec(canvassPlace.hash);
    const frame = row && data.frames[Number(row[1])];
    if (!frame) return;
    view.point(frame[NANOS] / 1e3);
    tell(frame[NANOS] / 1e9);
  });
  if (parent !== window) {
    addEventListener('message', ({ source, data: told }) => {
      if (source === parent && Number.isFinite(told?.cursor)) view.point(told.cursor * 1e6);
    });
  }
})();
