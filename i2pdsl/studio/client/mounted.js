// Mounts a film in a shadow root of its own: names inside, such as those of sprites, are its own.
import { fetched, h, sheetOf } from "./dom.js";
import { mount } from "/render/page/player.js";

const kinds = {}; // by its script, what draws a kind of film: a promise of the module
let styles = () => Promise.all(["/render/page/page.css", "/film.css"].map(sheetOf));

/** What is at hand without a server: modules of kinds by their scripts, and stylesheets. */
export function provide(modules, sheets) {
  Object.assign(kinds, modules);
  styles = () => sheets;
}

/** Makes a host fit to mount films in. */
export function filmHost(attributes = {}) {
  const host = h("div", attributes);
  const root = host.attachShadow({ mode: "open" });
  Promise.resolve(styles()).then((found) => (root.adoptedStyleSheets = found));
  return host;
}

/** Mounts what a film's `play` holds in a host, in place of what was there. Returns its playback,
 * with the drawing's `root` and `svg`; null where another film was mounted meanwhile. */
export async function mountFilm(host, play, options = {}) {
  host.film = play;
  const { makeStage } = await fetched(kinds, play.script, () => import(`/render/${play.script}`));
  if (host.film !== play) return null;
  const root = host.shadowRoot;
  const template = document.createElement("template");
  template.innerHTML = play.stage;
  const box = h("div", { class: `${play.classes} mounted` }, template.content);
  box.style.setProperty("--aspect", play.aspect);
  root.replaceChildren(box);
  const playback = mount(root, play, makeStage(play, root), options);
  return Object.assign(playback, { root, svg: root.querySelector("svg"), box });
}
