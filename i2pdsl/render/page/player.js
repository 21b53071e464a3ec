// Plays a film: draws the stage at each moment and moves the line along the belief curves.
// Times are frames: 0 is the start, frame t of the script ends at time t. Clocks are seconds at
// speed 1: see clock.js. The scripts before this one define makeClock(film), and makeStage(film),
// whose draw(time) moves the drawing.
(() => {
  "use strict";

  const film = JSON.parse(document.getElementById("film-data").textContent);
  const $ = (id) => document.getElementById(id);
  const SPEEDS = [0.5, 1, 2, 4];
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

  const stage = makeStage(film);

  // ------------------------------------------------------------------ the belief curves

  const T = film.last;
  const box = film.plot; // left, right, top, bottom in the plots' own units
  const atX = (t) => box.left + ((box.right - box.left) * t) / Math.max(T, 1);
  const atY = (panel, v) =>
    box.bottom - ((box.bottom - box.top) * (v - panel.low)) / (panel.high - panel.low);
  const plots = [...document.querySelectorAll(".plot")].map((node, i) => ({
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

  function drawCurves() {
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

  const phrase = (plot, t) =>
    plot.series.map((series) => `${series.label} ${say(plot, valueAt(series, t))}`).join(", ");

  // ------------------------------------------------------------------ time

  let time = 0;
  let speed = 1;
  let playing = false;
  let clock = 0; // while it plays
  let before = 0; // the browser's clock at the last picture, in milliseconds

  const { clockAt, timeAt } = makeClock(film);

  const name = (t) => (t === 0 ? "start" : `frame ${t} of ${T}`);

  function draw() {
    stage.draw(time);
    drawCurves();
    const frame = Math.ceil(time - 1e-9); // the one that is happening, or has just ended
    $("scrubber").value = time;
    $("scrubber").style.setProperty("--done", `${(100 * time) / Math.max(T, 1)}%`);
    if (frame === draw.frame) return;
    draw.frame = frame;
    $("scrubber").setAttribute("aria-valuetext", name(frame));
    $("counter").textContent = `${frame} / ${T}`;
    $("frame-number").textContent = frame === 0 ? "Start" : `Frame ${frame}`;
    $("caption").textContent = film.captions[frame];
    const begun = lines.filter((line) => Number(line.dataset.frame) <= frame);
    for (const line of lines) mark(line, line === begun[begun.length - 1]);
    const isWithin = (first, last) => Number(first) <= frame && frame <= Number(last);
    for (const node of reasons) node.hidden = !isWithin(node.dataset.first, node.dataset.last);
    for (const link of links) mark(link, isWithin(link.dataset.first, link.dataset.frame));
    for (const plot of plots) {
      plot.node.setAttribute("aria-valuenow", frame);
      plot.node.setAttribute("aria-valuetext", `${name(frame)}: ${phrase(plot, frame)}`);
    }
  }

  function mark(line, isCurrent) {
    if (isCurrent) line.setAttribute("aria-current", "step");
    else line.removeAttribute("aria-current");
  }

  // Speaks only of moments at rest: a film that talked at every frame would be unbearable.
  function announce() {
    const frame = Math.round(time);
    const said = plots.map((plot) => `${plot.title}: ${phrase(plot, frame)}.`);
    $("live").textContent = [`${name(frame)}: ${film.captions[frame]}.`, ...said].join(" ");
  }

  function seek(t) {
    pause();
    time = clamp(t, 0, T);
    draw();
    announce();
    const plot = plots.find((p) => p.node === document.activeElement);
    if (plot && probed === null) showTip(plot, Math.round(time));
  }

  const leap = Math.max(5, Math.round(T / 40)); // frames
  const step = (by) => seek(by > 0 ? Math.floor(time + 1e-6) + by : Math.ceil(time - 1e-6) + by);

  function advance(now) {
    if (!playing) return;
    const passed = clamp(now - before, 0, 100); // a tab that slept goes on where it was
    before = now;
    clock += (passed / 1000) * speed;
    time = timeAt(clock);
    draw();
    if (time < T) requestAnimationFrame(advance);
    else {
      pause();
      announce();
    }
  }

  function setPlaying(on) {
    playing = on;
    $("play").classList.toggle("playing", on);
    $("play").setAttribute("aria-label", on ? "Pause" : "Play");
  }

  function play() {
    if (playing || T === 0) return;
    if (time >= T) time = 0;
    hideTip();
    setPlaying(true);
    clock = clockAt(time);
    before = performance.now();
    requestAnimationFrame(advance);
  }

  function pause() {
    if (playing) setPlaying(false);
  }

  function toggle() {
    if (!playing) return play();
    pause();
    announce();
  }

  function setSpeed(to) {
    speed = to;
    document.querySelector(`#speeds [value="${to}"]`).checked = true;
  }

  const faster = (by) => setSpeed(SPEEDS[clamp(SPEEDS.indexOf(speed) + by, 0, SPEEDS.length - 1)]);

  // ------------------------------------------------------------------ hands on it

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

  const lines = [...document.querySelectorAll("#happenings button")];
  const reasons = [...document.querySelectorAll("#reasons > li")];
  const links = [...document.querySelectorAll(".why nav button")];
  for (const button of document.querySelectorAll("[data-frame]")) {
    button.addEventListener("click", () => seek(Number(button.dataset.frame)));
  }
  document.querySelector("main").classList.add("following");

  document.addEventListener("keydown", (event) => {
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

  function frameAt(plot, event) {
    const frame = plot.node.querySelector("svg").getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width) * box.width;
    return clamp(Math.round(((x - box.left) / (box.right - box.left)) * T), 0, T);
  }

  function showTip(plot, t) {
    const tip = $("tip");
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
    const pinned = getComputedStyle(document.querySelector(".theatre")).position === "sticky";
    const roof = pinned ? frame : plot.node.parentNode.getBoundingClientRect();
    const under = frame.bottom + height + 10 < innerHeight;
    const top = under ? frame.bottom + 4 : roof.top - height - 4;
    tip.style.transform = `translate(${left + scrollX}px, ${top + scrollY}px)`;
  }

  function hideTip() {
    probed = null;
    $("tip").hidden = true;
  }

  for (const plot of plots) {
    plot.node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      plot.node.setPointerCapture(event.pointerId);
      seek(frameAt(plot, event));
    });
    plot.node.addEventListener("pointermove", (event) => {
      probed = frameAt(plot, event);
      if (plot.node.hasPointerCapture(event.pointerId)) seek(probed);
      showTip(plot, probed);
      drawCurves();
    });
    for (const kind of ["pointerleave", "pointercancel", "blur"]) {
      plot.node.addEventListener(kind, () => {
        hideTip();
        drawCurves();
      });
    }
    plot.node.addEventListener("focus", () => {
      if (!playing) showTip(plot, Math.round(time));
    });
  }

  draw();
  $("still").hidden = true;
  // Several in one notebook shall not move all at once.
  const framed = window !== window.top;
  if (!calm.matches && !framed) play();
})();
