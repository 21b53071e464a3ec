// Moves hoppers on the hill. See hill/rig.py, whose `pose_vector` and `path_data` this file repeats:
// every point of the drawing is a sum of complex weights times the numbers of a pose.
export const makeStage = (film, root = document) => {
  const TAKES = { M: 1, L: 1, Q: 2, C: 3, Z: 0 };
  const NODES = 19;
  const { scale, grain, pairs, grounded, rope, colors } = film;

  // ------------------------------------------------------------------ what was recorded

  function summed(steps) {
    const values = new Float32Array(steps.length);
    let sum = 0;
    steps.forEach((step, t) => {
      sum += step;
      values[t] = sum / grain;
    });
    return values;
  }

  const shows = film.performances.map((performance, i) => {
    const show = root.getElementById(`show-${i}`);
    const lane = root.querySelectorAll(".lanes li")[i];
    const layers = [...show.querySelectorAll(".layer")];
    return {
      ...performance,
      last: performance.camera.length - 1,
      positions: performance.positions.map(summed), // x of all nodes, then y
      pull: performance.pull.map(summed),
      camera: summed(performance.camera),
      distance: summed(performance.distance),
      layers: layers.map((node) => ({ node: node.firstChild, share: Number(node.dataset.share) })),
      paths: [...show.querySelectorAll(".cast path")],
      sign: show.querySelector(".window-sign"),
      way: lane.querySelector(".way"),
      told: lane.querySelector("b"),
    };
  });
  const ways = shows.flatMap((show) => [...show.distance]);
  const farthest = Math.max(1, ways.reduce((a, b) => Math.max(a, b), 0));

  function at(values, time) {
    const t = Math.min(Math.floor(time), values.length - 1);
    const next = Math.min(t + 1, values.length - 1);
    return values[t] + (values[next] - values[t]) * (time - t);
  }

  // ------------------------------------------------------------------ a pose

  // Real parts, then imaginary parts, of the vector of a pose.
  function poseVector(show, time) {
    const numbers = show.positions.map((course) => at(course, time));
    const x = numbers.slice(0, NODES);
    const y = numbers.slice(NODES);
    const re = [...x];
    const im = [...y];
    for (const [a, b] of pairs) {
      const length = Math.max(Math.hypot(x[b] - x[a], y[b] - y[a]), 1e-9);
      re.push((x[b] - x[a]) / length);
      im.push((y[b] - y[a]) / length);
    }
    for (const node of grounded) {
      re.push(x[node]);
      im.push(x[node] * show.rise);
    }
    const away = Math.hypot(x[rope.hand] - x[rope.hook], y[rope.hand] - y[rope.hook]);
    re.push(0);
    im.push(-Math.sqrt(0.375 * away * Math.max(rope.length - away, 0)));
    return [re, im];
  }

  function point(weights, [re, im]) {
    let x = 0;
    let y = 0;
    for (let i = 0; i < weights.length; i += 3) {
      const [k, a, b] = [weights[i], weights[i + 1], weights[i + 2]];
      x += a * re[k] - b * im[k];
      y += a * im[k] + b * re[k];
    }
    return `${(scale * x).toFixed(1)} ${(-scale * y).toFixed(1)}`;
  }

  function pathData(part, vector) {
    let i = 0;
    let path = "";
    for (const command of part.shape) {
      const taken = part.points.slice(i, (i += TAKES[command]));
      path += command + taken.map((weights) => point(weights, vector)).join(" ");
    }
    return path;
  }

  const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

  function muscleColor(pull) {
    const [from, to] = [rgb(colors.idle), rgb(pull < 0 ? colors.short : colors.long)];
    const share = Math.min(Math.abs(pull), 1);
    return `rgb(${from.map((v, i) => Math.round(v + (to[i] - v) * share)).join(" ")})`;
  }

  // ------------------------------------------------------------------ a moment

  function drawShow(show, now) {
    const time = Math.min(now, show.last); // who ends early rests
    const camera = at(show.camera, time);
    for (const { node, share } of show.layers) {
      const x = scale * share * camera;
      node.setAttribute("transform", `translate(${(-x).toFixed(2)} ${(x * show.rise).toFixed(2)})`);
    }
    const vector = poseVector(show, time);
    film.parts.forEach((part, i) => {
      show.paths[i].setAttribute("d", pathData(part, vector));
      if (part.muscle === null) return;
      // The pull of a frame lasts for all of it, and is felt from its beginning.
      show.paths[i].setAttribute("stroke", muscleColor(show.pull[part.muscle][Math.ceil(time)]));
    });
    const window = show.windows.find(([first, last]) => first <= time && time <= last);
    show.sign.hidden = !(window && window[2]);
    if (window) show.sign.textContent = window[2];
    const distance = at(show.distance, time);
    show.way.style.width = `${(100 * Math.max(distance, 0)) / farthest}%`;
    show.told.textContent = `${distance.toFixed(0).replace(/^-0$/, "0").replace("-", "−")} units`;
  }

  return { draw: (time) => shows.forEach((show) => drawShow(show, time)) };
};
