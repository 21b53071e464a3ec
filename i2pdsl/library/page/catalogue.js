// Plays the films of examples in their places: unpacked and mounted when somebody asks for one.
import { mount } from "/render/page/player.js";
import { makers } from "/makers.js";

const HOVER = 350; // milliseconds that a pointer rests on a comic before its film plays
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches || !matchMedia("(hover: hover)").matches;
const playing = new Set();

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text());
}

/** Puts a film with its controls in place of a comic. */
async function show(place) {
  if (place.dataset.shown) return;
  place.dataset.shown = "yes";
  const packed = place.querySelector("script");
  const film = await unpacked(packed.textContent);
  const host = document.createElement("div");
  host.className = "player";
  const root = host.attachShadow({ mode: "open" });
  const style = document.querySelector("style").cloneNode(true);
  const player = document.getElementById("player").content.cloneNode(true);
  root.append(style, player);
  root.getElementById("scrubber").max = film.last;
  root.getElementById("counter").textContent = `0 / ${film.last}`;
  const stage = document.createElement("template");
  stage.innerHTML = film.stage;
  const section = root.querySelector("section");
  section.className = film.classes;
  section.style.setProperty("--aspect", film.aspect);
  root.querySelector("figure").prepend(stage.content);
  place.querySelector(".strip").replaceWith(host);
  place.querySelector(".play-here").remove();
  const playback = mount(root, film, makers[packed.dataset.script](film, root));
  for (const other of playing) other.pause();
  playing.add(playback);
  playback.play();
  return root;
}

for (const place of document.querySelectorAll(".place")) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "play-here";
  button.textContent = "Play it here";
  button.setAttribute("aria-label", `Play it here: ${place.dataset.label}`);
  button.addEventListener("click", async () => {
    const root = await show(place);
    root?.getElementById("play").focus();
  });
  place.append(button);
  let waits = 0;
  const comic = place.querySelector(".strip");
  comic.addEventListener("pointerenter", () => {
    if (!calm) waits = setTimeout(() => show(place), HOVER);
  });
  comic.addEventListener("pointerleave", () => clearTimeout(waits));
}
