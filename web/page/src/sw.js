// Caches the page, so that it opens off line. It requests only the page's own files.
const KEPT = "canvass-VERSION";
const FILES = ["./index.html", "./manifest.webmanifest"];

addEventListener("install", (event) => event.waitUntil(caches.open(KEPT).then((cache) => cache.addAll(FILES)).then(() => skipWaiting())));

addEventListener("activate", (event) =>
  event.waitUntil(caches.keys().then((names) => Promise.all(names.filter((name) => name !== KEPT).map((name) => caches.delete(name))))),
);

addEventListener("fetch", (event) => {
  const { request } = event;
  const wanted = request.mode === "navigate" ? "./index.html" : request;
  event.respondWith(caches.match(wanted, { ignoreSearch: true }).then((kept) => kept ?? fetch(request)));
});
