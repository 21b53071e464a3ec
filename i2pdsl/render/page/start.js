// Mounts the one film of a page.
import { mount } from "./player.js";

(() => {
  const film = JSON.parse(document.getElementById("film-data").textContent);
  const player = mount(document, film, makeStage(film, document));
  document.querySelector("main").classList.add("following");
  document.getElementById("still").hidden = true;
  // Several in one notebook shall not move all at once.
  const framed = window !== window.top;
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches && !framed) player.play();
})();
