// Plays a film: moves the actors along their keyframes and the line along the belief curves.
// Times are turns: 0 is the start, frame t of the script ends at time t. See choreography.py,
// whose `sample` this file repeats.
(() => {
  "use strict";

  const film = JSON.parse(document.getElementById("film-data").textContent);
  const $ = (id) => document.getElementById(id);
  const SVG = "http://www.w3.org/2000/svg";
  const SPEEDS = [0.5, 1, 2, 4];
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

  // ------------------------------------------------------------------ keyframes

  const FIELDS = ["x", "y", "angle", "scaleX", "scaleY", "opacity", "lift"];

  const bend = {
    linear: (u) => u,
    in: (u) => u * u,
    out: (u) => 1 - (1 - u) * (1 - u),
    "in-out": (u) => u * u * (3 - 2 * u),
    hold: () => 0,
  };

  // A key is [time, x, y, angle, scale_x, scale_y, opacity, lift, ease, pose].
  function sample(track, time) {
    let low = 0;
    let high = track.length; // the first key later than `time`
    while (low < high) {
      const middle = (low + high) >> 1;
      if (time < track[middle][0]) high = middle;
      else low = middle + 1;
    }
    const a = track[Math.max(low - 1, 0)];
    const b = low === 0 ? a : track[Math.min(low, track.length - 1)];
    const w = a === b ? 0 : bend[a[8]]((time - a[0]) / (b[0] - a[0]));
    const key = { pose: a[9] };
    FIELDS.forEach((field, i) => {
      key[field] = a[i + 1] + w * (b[i + 1] - a[i + 1]);
    });
    return key;
  }

  // ------------------------------------------------------------------ the stage

  const { cell, foot } = film;
  const scene = $("actors");
  const cast = film.actors.map((actor, index) => {
    const find = (part) => scene.querySelector(`[data-index="${index}"][data-part="${part}"]`);
    return { ...actor, index, shadow: find("shadow"), body: find("actor") };
  });
  const marks = film.marks.map((mark) => {
    const use = document.createElementNS(SVG, "use");
    use.setAttribute("href", `#${mark.symbol}`);
    use.style.display = "none";
    $("marks").append(use);
    return { ...mark, use };
  });

  function place(use, key, pivotX, pivotY) {
    use.setAttribute(
      "transform",
      `translate(${(key.x + 0.5) * cell} ${(key.y + pivotY / 100 - key.lift) * cell})` +
        ` rotate(${key.angle * 360})` +
        ` scale(${(key.scaleX * cell) / 100} ${(key.scaleY * cell) / 100})` +
        ` translate(${-pivotX} ${-pivotY})`,
    );
    use.setAttribute("opacity", key.opacity);
  }

  function drawStage() {
    const seen = cast.map((actor) => ({ actor, key: sample(actor.keys, time) }));
    for (const { actor, key } of seen) {
      place(actor.body, key, 50, foot);
      const href = `#${actor.symbols[key.pose]}`;
      if (actor.body.getAttribute("href") !== href) actor.body.setAttribute("href", href);
      // The higher the actor, the smaller and fainter its shadow.
      const size = key.scaleX / (1 + 0.22 * key.lift);
      const floor = (key.y + foot / 100 - 0.015) * cell;
      actor.shadow.setAttribute(
        "transform",
        `translate(${(key.x + 0.5) * cell} ${floor}) scale(${size})`,
      );
      actor.shadow.setAttribute("opacity", key.opacity / (1 + 0.3 * key.lift));
    }
    // Who is nearer hides who is farther; nodes are only moved where the order has changed.
    seen.sort((p, q) => p.key.y - q.key.y);
    const order = [...cast.map((actor) => actor.shadow), ...seen.map(({ actor }) => actor.body)];
    order.forEach((node, i) => {
      if (scene.children[i] !== node) scene.insertBefore(node, scene.children[i]);
    });
    for (const { keys, use } of marks) {
      const shown = keys[0][0] < time && time < keys[keys.length - 1][0];
      use.style.display = shown ? "" : "none";
      if (shown) place(use, sample(keys, time), 50, 50);
    }
  }

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
  let before = 0; // the clock at the last picture, in milliseconds

  const name = (t) => (t === 0 ? "start" : `frame ${t} of ${T}`);

  function draw() {
    drawStage();
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
    for (const line of lines) {
      if (Number(line.dataset.frame) === frame) line.setAttribute("aria-current", "step");
      else line.removeAttribute("aria-current");
    }
    for (const plot of plots) {
      plot.node.setAttribute("aria-valuenow", frame);
      plot.node.setAttribute("aria-valuetext", `${name(frame)}: ${phrase(plot, frame)}`);
    }
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

  const step = (by) => seek(by > 0 ? Math.floor(time + 1e-6) + by : Math.ceil(time - 1e-6) + by);

  function advance(clock) {
    if (!playing) return;
    const passed = clamp(clock - before, 0, 100); // a tab that slept goes on where it was
    before = clock;
    time = Math.min(time + ((passed / 1000) * speed) / film.seconds, T);
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
  for (const line of lines) line.addEventListener("click", () => seek(Number(line.dataset.frame)));

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
        PageDown: () => step(-5),
        PageUp: () => step(5),
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
  if (!calm.matches) play();
})();
