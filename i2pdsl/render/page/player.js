// Plays a film in what a root holds of a player: a whole document, or a shadow root, so that several
// films on one page have names of their own. Of its parts (controls, belief curves, lists of what
// happens) each may be missing. `stage` comes of the makeStage(film, root) of the kind of film; its
// draw(time) moves the drawing. Times are frames: 0 is the start, frame t of the script ends at
// time t. Returns the film's playback.
import { SPEEDS, clamp, makePlayback } from "./playback.js";

export const mount = (root, film, stage, { onDraw = () => {} } = {}) => {
  const $ = (id) => root.getElementById(id);
  const T = film.last;
  const name = (t) => (t === 0 ? "start" : `frame ${t} of ${T}`);
  let shownFrame = null;

  const playback = makePlayback(film, { draw, changed, rested });
  const curves = $("tip") ? makeCurves(root, film, playback, name) : null;
  const lines = [...root.querySelectorAll("#happenings button")];
  const reasons = [...root.querySelectorAll("#reasons > li")];
  const links = [...root.querySelectorAll(".why nav button")];
  for (const button of root.querySelectorAll("[data-frame]")) {
    button.addEventListener("click", () => playback.seek(Number(button.dataset.frame)));
  }

  function draw(time) {
    stage.draw(time);
    curves?.draw(time);
    onDraw(time);
    $("scrubber")?.style.setProperty("--done", `${(100 * time) / Math.max(T, 1)}%`);
    if ($("scrubber")) $("scrubber").value = time;
    const frame = Math.ceil(time - 1e-9); // the one that is happening, or has just ended
    if (frame === shownFrame) return;
    shownFrame = frame;
    if ($("scrubber")) {
      $("scrubber").setAttribute("aria-valuetext", name(frame));
      $("counter").textContent = `${frame} / ${T}`;
    }
    if ($("caption")) {
      $("frame-number").textContent = frame === 0 ? "Start" : `Frame ${frame}`;
      $("caption").textContent = film.captions[frame];
    }
    const begun = lines.filter((line) => Number(line.dataset.frame) <= frame);
    for (const line of lines) mark(line, line === begun[begun.length - 1]);
    const isWithin = (first, last) => Number(first) <= frame && frame <= Number(last);
    for (const node of reasons) node.hidden = !isWithin(node.dataset.first, node.dataset.last);
    for (const link of links) mark(link, isWithin(link.dataset.first, link.dataset.frame));
    curves?.tell(frame);
  }

  function mark(line, isCurrent) {
    if (isCurrent) line.setAttribute("aria-current", "step");
    else line.removeAttribute("aria-current");
  }

  // Speaks only of moments at rest: a film that talked at every frame would be unbearable.
  function rested() {
    const frame = Math.round(playback.time);
    const said = curves ? curves.said(frame) : [];
    if ($("live")) {
      $("live").textContent = [`${name(frame)}: ${film.captions[frame]}.`, ...said].join(" ");
    }
    curves?.follow(frame);
  }

  function changed(playing) {
    if (playing) curves?.hideTip();
    $("play")?.classList.toggle("playing", playing);
    $("play")?.setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  if ($("play")) takeHold(root, T, playback);
  draw(0);
  return playback;
};

// ------------------------------------------------------------------ hands on it

const takeHold = (root, T, playback) => {
  const $ = (id) => root.getElementById(id);
  const leap = Math.max(5, Math.round(T / 40)); // frames
  const { seek, step, toggle } = playback;

  function setSpeed(to) {
    playback.setSpeed(to);
    root.querySelector(`#speeds [value="${to}"]`).checked = true;
  }

  function faster(by) {
    setSpeed(SPEEDS[clamp(SPEEDS.indexOf(playback.speed) + by, 0, SPEEDS.length - 1)]);
  }

  $("play").addEventListener("click", toggle);
  $("restart").addEventListener("click", () => seek(0));
  $("back").addEventListener("click", () => step(-1));
  $("forward").addEventListener("click", () => step(1));
  $("speeds").addEventListener("change", (event) => setSpeed(Number(event.target.value)));
  $("scrubber").addEventListener("input", (event) => {
    const t = Number(event.target.value);
    const whole = Math.round(t);
    seek(Math.abs(t - whole) < 0.15 ? whole : t); // whole frames hold on to the thumb
  });

  root.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const on = event.target;
    const slides = on.matches("#scrubber, .plot");
    const chooses = on.matches("[type=radio]") && event.key.startsWith("Arrow");
    const presses = event.key === " " && on.matches("button, summary");
    const scrolls = on.matches("pre") && event.key.startsWith("Arrow");
    if (chooses || presses || scrolls) return; // these have a use for the key themselves
    const keys = {
      " ": toggle,
      ArrowLeft: () => step(-1),
      ArrowRight: () => step(1),
      Home: () => seek(0),
      End: () => seek(T),
      "+": () => faster(1),
      "=": () => faster(1),
      "-": () => faster(-1),
      ...(slides && {
        ArrowDown: () => step(-1),
        ArrowUp: () => step(1),
        PageDown: () => step(-leap),
        PageUp: () => step(leap),
      }),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
};

// ------------------------------------------------------------------ the belief curves

const makeCurves = (root, film, playback, name) => {
  const T = film.last;
  const tip = root.getElementById("tip");
  const box = film.plot; // left, right, top, bottom in the plots' own units
  const atX = (t) => box.left + ((box.right - box.left) * t) / Math.max(T, 1);
  const atY = (panel, v) =>
    box.bottom - ((box.bottom - box.top) * (v - panel.low)) / (panel.high - panel.low);
  const plots = [...root.querySelectorAll(".plot")].map((node, i) => ({
    ...film.panels[i],
    node,
    now: node.querySelector(".now"),
    probe: node.querySelector(".probe"),
    dots: [...node.querySelectorAll(".here")],
    numbers: [...node.parentNode.querySelectorAll("li b")],
  }));
  let probed = null; // the frame under the pointer

  function valueAt(series, t) {
    const k = Math.min(Math.floor(t), T);
    const [a, b] = [series.values[k], series.values[Math.min(k + 1, T)]];
    return a === null || t === k ? a : b === null ? null : a + (b - a) * (t - k);
  }

  function say(plot, value) {
    if (value === null) return "–";
    return (plot.kind === "probability" ? value.toFixed(3) : value.toFixed(1)).replace("-", "−");
  }

  const phrase = (plot, t) =>
    plot.series.map((series) => `${series.label} ${say(plot, valueAt(series, t))}`).join(", ");

  function draw(time) {
    const told = probed ?? time;
    for (const plot of plots) {
      plot.now.setAttribute("transform", `translate(${atX(time)} 0)`);
      plot.probe.style.display = probed === null ? "none" : "";
      if (probed !== null) plot.probe.setAttribute("transform", `translate(${atX(probed)} 0)`);
      plot.series.forEach((series, i) => {
        const value = valueAt(series, told);
        plot.numbers[i].textContent = say(plot, value);
        plot.dots[i].style.display = value === null ? "none" : "";
        if (value === null) return;
        plot.dots[i].setAttribute("cx", atX(told));
        plot.dots[i].setAttribute("cy", atY(plot, value));
      });
    }
  }

  function tell(frame) {
    for (const plot of plots) {
      plot.node.setAttribute("aria-valuenow", frame);
      plot.node.setAttribute("aria-valuetext", `${name(frame)}: ${phrase(plot, frame)}`);
    }
  }

  const said = (frame) => plots.map((plot) => `${plot.title}: ${phrase(plot, frame)}.`);

  function follow(frame) {
    const plot = plots.find((p) => p.node === root.activeElement);
    if (plot && probed === null) showTip(plot, frame);
  }

  function frameAt(plot, event) {
    const frame = plot.node.querySelector("svg").getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width) * box.width;
    return clamp(Math.round(((x - box.left) / (box.right - box.left)) * T), 0, T);
  }

  function showTip(plot, t) {
    const heading = document.createElement("strong");
    heading.textContent = name(t);
    const rows = plot.series.map((series) => {
      const row = document.createElement("div");
      const [label, value] = [document.createElement("span"), document.createElement("b")];
      label.textContent = series.label;
      value.textContent = say(plot, valueAt(series, t));
      row.append(label, value);
      return row;
    });
    tip.replaceChildren(heading, ...rows);
    tip.hidden = false;
    const frame = plot.node.getBoundingClientRect();
    const x = frame.left + (frame.width * atX(t)) / box.width;
    const { width, height } = tip.getBoundingClientRect();
    const left = clamp(x - width / 2, 6, document.documentElement.clientWidth - width - 6);
    // Under the plot, else above its card, else (the film is pinned there) over the legend.
    const pinned = getComputedStyle(root.querySelector(".theatre")).position === "sticky";
    const roof = pinned ? frame : plot.node.parentNode.getBoundingClientRect();
    const under = frame.bottom + height + 10 < innerHeight;
    const top = under ? frame.bottom + 4 : roof.top - height - 4;
    tip.style.transform = `translate(${left + scrollX}px, ${top + scrollY}px)`;
  }

  function hideTip() {
    probed = null;
    tip.hidden = true;
  }

  for (const plot of plots) {
    plot.node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      plot.node.setPointerCapture(event.pointerId);
      playback.seek(frameAt(plot, event));
    });
    plot.node.addEventListener("pointermove", (event) => {
      probed = frameAt(plot, event);
      if (plot.node.hasPointerCapture(event.pointerId)) playback.seek(probed);
      showTip(plot, probed);
      draw(playback.time);
    });
    for (const kind of ["pointerleave", "pointercancel", "blur"]) {
      plot.node.addEventListener(kind, () => {
        hideTip();
        draw(playback.time);
      });
    }
    plot.node.addEventListener("focus", () => {
      if (!playback.isPlaying) showTip(plot, Math.round(playback.time));
    });
  }

  return { draw, tell, said, follow, hideTip };
};
