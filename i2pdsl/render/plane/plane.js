// Moves discs in a plane. See plane/figures.py, whose `trail_pieces` and `face_moves` this file
// repeats; places are in pixels of the drawing, y down, gazes point up where they are positive.
export const makeStage = (film, root = document) => {
  const { trail, eyes } = film;

  const shows = film.performances.map((performance, i) => {
    const show = root.getElementById(`show-${i}`);
    const [shadows, figures] = [".shadow", ".figure"].map((kind) => show.querySelectorAll(kind));
    // The key below the room has figures too: those of the cast come last.
    const first = figures.length - performance.cast.length;
    return {
      windows: performance.windows,
      last: performance.cast[0].x.length - 1,
      sign: show.querySelector(".window-sign"),
      cast: performance.cast.map((who, k) => {
        const figure = figures[first + k];
        figure.setAttribute("data-actor", who.name);
        const lines = show.querySelector(`[data-who="${k}"]`);
        return {
          ...who,
          figure,
          shadow: shadows[k],
          face: figure.querySelector(".face"),
          pupils: figure.querySelector(".pupils"),
          way: lines.querySelector(".way"),
          pieces: [...lines.querySelectorAll(".piece")],
        };
      }),
    };
  });

  function at(course, time) {
    const t = Math.min(Math.floor(time), course.length - 1);
    const next = Math.min(t + 1, course.length - 1);
    return course[t] + (course[next] - course[t]) * (time - t);
  }

  const point = (who, time) => `${at(who.x, time).toFixed(1)} ${at(who.y, time).toFixed(1)}`;

  function line(who, first, last) {
    const points = [point(who, first)];
    for (let t = Math.floor(first) + 1; t < last; t += 1) points.push(point(who, t));
    points.push(point(who, last));
    return `M${points.join("L")}`;
  }

  function drawTrail(who, time) {
    const first = Math.max(time - trail.span, 0);
    who.way.setAttribute("d", line(who, 0, first));
    const part = who.dashed ? trail.dash : 1;
    let edge = Math.floor(first / who.step) * who.step;
    for (const piece of who.pieces) {
      const begin = Math.max(edge, first);
      const end = Math.min(edge + part * who.step, time);
      edge += who.step;
      if (begin < end) {
        const strength = Math.max(0, 1 - (time - end) / trail.span);
        const opacity = trail.faint + (trail.strong - trail.faint) * strength;
        const width = trail.width * (trail.thin + (1 - trail.thin) * strength);
        piece.setAttribute("d", line(who, begin, end));
        piece.setAttribute("stroke-opacity", opacity.toFixed(3));
        piece.setAttribute("stroke-width", width.toFixed(2));
      } else piece.removeAttribute("d");
    }
  }

  const move = (x, y) => `translate(${x.toFixed(2)} ${y.toFixed(2)})`;

  function drawFigure(who, time) {
    const place = `${move(at(who.x, time), at(who.y, time))} scale(${who.size.toFixed(4)})`;
    who.figure.setAttribute("transform", place);
    who.shadow.setAttribute("transform", place);
    const [x, y] = [at(who.gazeX, time), at(who.gazeY, time)];
    for (const part of ["face", "pupils"]) {
      who[part].setAttribute("transform", move(x * eyes[part][0], y * eyes[part][1]));
    }
  }

  function draw(now) {
    for (const show of shows) {
      const time = Math.min(now, show.last); // who ends early rests
      for (const who of show.cast) {
        drawTrail(who, time);
        drawFigure(who, time);
      }
      const window = show.windows.find(([first, last]) => first <= time && time <= last);
      show.sign.hidden = !(window && window[2]);
      if (window) show.sign.textContent = window[2];
    }
  }

  return { draw };
};
