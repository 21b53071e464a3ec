// Moves a kitchen's cast along keyframes. See tracks.py, whose `sample` this file repeats.
// A sheet has several films: the parts of each one's drawing are known by their number.
export const makeStage = (film, root = document) => {
  const shows = film.shows
    ? film.shows.map((show, i) => makeShow(show, root, `-${i}`))
    : [makeShow(film, root, "")];
  return { draw: (time) => shows.forEach((show) => show.draw(time)) };
};

const makeShow = (film, root, number) => {
  const $ = (id) => root.getElementById(`${id}${number}`);
  const SVG = "http://www.w3.org/2000/svg";

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

  const { cell, foot, life } = film;
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
        ` scale(${(life * key.scaleX * cell) / 100} ${(life * key.scaleY * cell) / 100})` +
        ` translate(${-pivotX} ${-pivotY})`,
    );
    use.setAttribute("opacity", key.opacity);
  }

  function draw(time) {
    const seen = cast.map((actor) => ({ actor, key: sample(actor.keys, time) }));
    for (const { actor, key } of seen) {
      place(actor.body, key, 50, foot);
      const href = `#${actor.symbols[key.pose]}`;
      if (actor.body.getAttribute("href") !== href) actor.body.setAttribute("href", href);
      // The higher the actor, the smaller and fainter its shadow.
      const size = (life * key.scaleX) / (1 + 0.22 * key.lift);
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

  return { draw };
};
