// What viewers believe, below the film; and a curve that is drawn: what was drawn is `points(...)` in
// the text, and what the text has there is drawn.
import { clamp, follow, h, later, s } from "./dom.js";

const BOX = { width: 240, height: 128, left: 30, right: 234, top: 10, bottom: 106 };
const REACH = 14; // pixels about a point that take hold of it

const signed = (value) => String(value).replace("-", "−");
const short = (value) => signed(Number(Number(value).toPrecision(3)));

/** Axes of a plot: a curve's values go from `low` to `high`, frames from 0 to `last`. */
class Axes {
  constructor({ low, high, last }) {
    Object.assign(this, { low, high, last });
  }

  x = (share) => BOX.left + (BOX.right - BOX.left) * share;
  y = (value) =>
    BOX.bottom - ((BOX.bottom - BOX.top) * (value - this.low)) / (this.high - this.low || 1);
  shareAt = (x) => clamp((x - BOX.left) / (BOX.right - BOX.left), 0, 1);
  valueAt = (y) =>
    clamp(
      this.low + ((BOX.bottom - y) / (BOX.bottom - BOX.top)) * (this.high - this.low),
      this.low,
      this.high,
    );
  frameX = (frame) => this.x(frame / Math.max(this.last, 1));

  drawn(ticks = [this.low, (this.low + this.high) / 2, this.high]) {
    const lines = ticks.flatMap((value) => [
      s("path", { class: "grid", d: `M${BOX.left} ${this.y(value)}H${BOX.right}` }),
      s("text", { x: BOX.left - 5, y: this.y(value) + 3.5, "text-anchor": "end" }, short(value)),
    ]);
    const frames = [0, Math.round(this.last / 2), this.last].map((frame) =>
      s(
        "text",
        { x: this.frameX(frame), y: BOX.bottom + 14, "text-anchor": "middle" },
        String(frame),
      ),
    );
    return [...lines, ...frames];
  }

  path(values) {
    let [path, pen] = ["", "M"];
    values.forEach((value, frame) => {
      if (value === null) pen = "M";
      else {
        path += `${pen}${this.frameX(frame).toFixed(2)} ${this.y(value).toFixed(2)}`;
        pen = "L";
      }
    });
    return path;
  }
}

/** What a pointer drew, strictly forward, with an old line where it did not. */
function redrawn(old, stroke) {
  const sorted = [...stroke].sort((a, b) => a[0] - b[0]);
  const [from, to] = [sorted[0][0], sorted[sorted.length - 1][0]];
  const kept = old.filter(([x]) => x < from - 1e-6 || x > to + 1e-6);
  const joined = [...kept, ...sorted].sort((a, b) => a[0] - b[0]);
  return joined.filter(([x], i) => i === 0 || x - joined[i - 1][0] > 1e-4);
}

function valueIn(values, time) {
  const k = Math.min(Math.floor(time), values.length - 1);
  const [a, b] = [values[k], values[Math.min(k + 1, values.length - 1)]];
  return a === null || b === null ? a : a + (b - a) * (time - k);
}

export class Curves {
  #cards = []; // {node, axes, now, series: [{values, dot, told}]}
  #arc; // the card that is drawn on

  constructor(host, studio) {
    this.studio = studio;
    this.host = host;
    this.#arc = new Arc(studio);
    this.setFilm(null);
  }

  setFilm(film) {
    const panels = film?.play.panels ?? [];
    const wished = panels.filter(({ wish }) => wish); // what the story is about comes first
    this.#cards = [...wished, ...panels.filter((each) => !wished.includes(each))].map((panel) =>
      this.#card(panel, film.play),
    );
    this.host.replaceChildren(this.#arc.node, ...this.#cards.map(({ node }) => node));
    this.host.hidden = !film;
    this.#arc.setFilm(film);
    this.show(this.studio.time);
  }

  refresh() {
    this.#arc.refresh();
  }

  show(time) {
    this.#arc.show(time);
    for (const { axes, now, series } of this.#cards) {
      now.setAttribute("transform", `translate(${axes.frameX(time)} 0)`);
      for (const { values, dot, told } of series) {
        const value = valueIn(values, time);
        told.textContent = value === null ? "–" : signed(value.toFixed(2));
        dot.style.display = value === null ? "none" : "";
        if (value === null) continue;
        dot.setAttribute("cx", axes.frameX(time));
        dot.setAttribute("cy", axes.y(value));
      }
    }
  }

  #card(panel, play) {
    const axes = new Axes({ ...panel, last: play.last });
    const series = panel.series.map((one) => {
      const line = s(
        "g",
        { class: "curve" },
        s("path", {
          d: axes.path(one.values),
          "stroke-dasharray": one.dash?.length ? dashed(one.dash) : null,
        }),
      );
      const dot = s("circle", { class: "dot", r: 4 });
      const told = h("b");
      const name = h("li", {}, h("i", { class: "key" }), h("span", {}, one.label), told);
      const dots = s("g", { class: "curve" }, dot);
      for (const node of [line, dots, name]) node.style.setProperty("--hue", one.color);
      return { values: one.values, line, dots, dot, told, name };
    });
    const now = s("g", { class: "now" }, s("line", { y1: BOX.top, y2: BOX.bottom }));
    const shaded = (play.windows ?? []).map(({ first, last }) =>
      s("rect", {
        class: "window",
        x: axes.frameX(first),
        y: BOX.top,
        height: BOX.bottom - BOX.top,
        width: axes.frameX(last) - axes.frameX(first),
      }),
    );
    const svg = plot(
      ...shaded,
      ...axes.drawn(panel.ticks),
      now,
      series.map(({ line }) => line),
      series.map(({ dots }) => dots),
    );
    svg.addEventListener("pointerdown", (event) => {
      const seek = (next) =>
        this.studio.playback?.seek(Math.round(axes.shareAt(pointIn(svg, next)[0]) * play.last));
      seek(event);
      follow(svg, event, seek, () => {});
    });
    const node = h(
      "figure",
      { class: panel.wish ? "curve-card wished" : "curve-card" },
      h("figcaption", {}, panel.title),
      h(
        "ul",
        {},
        series.map(({ name }) => name),
      ),
      svg,
    );
    return { node, axes, now, series };
  }
}

const dashed = (dash) => dash.map((part) => 2.2 * part).join(" ");

const plot = (...children) =>
  s(
    "svg",
    { class: "plot", viewBox: `0 0 ${BOX.width} ${BOX.height}`, "aria-hidden": "true" },
    children.flat(),
  );

function pointIn(svg, event) {
  const matrix = svg.getScreenCTM().inverse();
  const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
  return [x, y];
}

/** An axis with room for all of some values, between round numbers. */
function roomy(values, last) {
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const room = 0.12 * (most - least || 1);
  const unit = 10 ** Math.floor(Math.log10(most - least + 2 * room)) / 2;
  return new Axes({
    low: unit * Math.floor((least - room) / unit),
    high: unit * Math.ceil((most + room) / unit),
    last,
  });
}

/** The card on which a curve is drawn over the measured one. */
class Arc {
  #film = null;
  #choices = []; // what can be drawn over: {label, expression}
  #own = []; // the same of what somebody typed
  #values = null; // [T + 1] as measured
  #points = null; // [[share, value], ...] as the text has them
  #range = null; // where
  #expression = null;
  #asked = 0;
  #drawing = false; // under a pointer nothing is drawn anew

  constructor(studio) {
    this.studio = studio;
    this.choice = h("select", { "aria-label": "Curve to draw", change: () => this.#chosen() });
    this.other = h("input", {
      hidden: true,
      "aria-label": "Expression to draw",
      placeholder: "entropy(rho | script[:t])",
      spellcheck: "false",
      change: () => this.#named(),
    });
    this.told = h("p", { class: "telling" }, "Draw over it with mouse or finger.");
    this.svg = plot();
    this.svg.removeAttribute("aria-hidden");
    this.svg.setAttribute("role", "group");
    this.svg.setAttribute("aria-label", "Drawn curve");
    this.svg.classList.add("drawable");
    this.svg.addEventListener("pointerdown", (event) => this.#draw(event));
    this.node = h(
      "figure",
      { class: "curve-card arc" },
      h("figcaption", {}, h("span", {}, "Draw"), this.choice),
      this.other,
      this.told,
      this.svg,
    );
  }

  async setFilm(film) {
    this.#film = film;
    if (!film) return;
    const number = ++this.#asked;
    const reply = await this.studio.ask("i2p/curves", {}, film);
    if (number !== this.#asked) return;
    if (reply) this.#choices = reply.curves;
    this.refresh(); // what is measured is asked of this film, whatever became of the choices
  }

  /** What the text says of drawn curves has changed. */
  refresh() {
    const drawn = this.studio.story?.curves ?? [];
    const all = [
      ...drawn.map(({ expression, range, points }, i) => ({
        label: expression ? `${expression}` : `points ${i + 1}`,
        expression,
        range,
        points,
      })),
      ...[...this.#own, ...this.#choices].filter(
        ({ expression }) => !drawn.some((one) => one.expression === expression),
      ),
      { label: "an expression …", expression: null },
    ];
    const before = this.choice.value;
    // Somebody is typing one, wherever that stands now; it is no choice where there is no other.
    const types = this.options?.length > 1 && Number(before) === this.options.length - 1;
    this.options = all;
    this.choice.replaceChildren(
      ...all.map(({ label, range }, i) => h("option", { value: i }, range ? `✎ ${label}` : label)),
    );
    // The same curve as before, or one that the text has.
    const same = all.findIndex(({ expression }) => expression && expression === this.#expression);
    const other = types ? all.length - 1 : before && all[before] ? Number(before) : 0;
    const index = same >= 0 ? same : other;
    this.choice.value = all[index] ? String(index) : "";
    this.#chosen();
  }

  /** An expression was typed. */
  #named() {
    const expression = this.other.value.trim();
    if (!expression) return;
    this.#own = [{ label: expression, expression }, ...this.#own];
    this.#expression = expression;
    this.other.value = "";
    this.refresh();
  }

  async #chosen() {
    const option = this.options?.[Number(this.choice.value)];
    this.#points = option?.points ?? null;
    this.#range = option?.range ?? null;
    this.other.hidden = this.#range !== null || Boolean(option?.expression);
    const changed = option?.expression !== this.#expression;
    this.#expression = option?.expression ?? null;
    if (changed) this.#values = null;
    this.#show();
    if (!option?.expression || !this.#film) return;
    const film = this.#film;
    const reply = await this.studio.ask("i2p/query", { expression: option.expression }, film);
    if (film !== this.#film || option.expression !== this.#expression || !reply) return;
    this.#values = this.#spread(reply);
    this.#show();
  }

  #spread({ times, series }) {
    const values = new Array(this.#film.play.last + 1).fill(null);
    const found = series[0]?.values ?? [];
    (times ?? found.map((_, t) => t)).forEach((t, i) => {
      if (t >= 0 && t < values.length) values[t] = found[i];
    });
    return values;
  }

  /** The axis of what is drawn, and that of what is measured: the same, but where a story draws in
   * units of its own (an arc from -1 to 1, say, for what a character hopes for). */
  #axes() {
    const last = this.#film?.play.last ?? 1;
    const measured = (this.#values ?? []).filter((v) => v !== null);
    const drawn = (this.#points ?? []).map(([, v]) => v);
    const within = (all, low, high) => all.every((v) => low <= v && v <= high);
    if (within([...measured, ...drawn], 0, 1)) return [new Axes({ low: 0, high: 1, last })];
    if (!measured.length || !drawn.length) return [roomy(measured.length ? measured : drawn, last)];
    const span = (all) => Math.max(...all) - Math.min(...all) || 1e-9;
    const ratio = span([...measured, ...drawn]) / Math.max(span(measured), span(drawn));
    const alike =
      ratio < 1.5 && span(measured) < 4 * span(drawn) && span(drawn) < 4 * span(measured);
    if (alike) return [roomy([...measured, ...drawn], last)];
    return [roomy(drawn, last), roomy(measured, last)];
  }

  #show() {
    if (this.#drawing) return;
    const [axes, own = axes] = this.#axes();
    this.axes = axes;
    this.now = s("g", { class: "now" }, s("line", { y1: BOX.top, y2: BOX.bottom }));
    const target = s("path", { class: "target", d: this.#line(this.#points ?? []) });
    const focused = this.svg.querySelector(".handle:focus")?.dataset.point;
    const handles = (this.#points ?? []).map((point, i) => this.#handle(point, i));
    this.svg.replaceChildren(
      ...axes.drawn(),
      this.now,
      s("path", { class: "measured", d: this.#values ? own.path(this.#values) : "" }),
      target,
      ...handles,
    );
    if (focused) this.svg.querySelector(`[data-point="${focused}"]`)?.focus();
    this.told.textContent = this.#points
      ? "Dashed: as drawn. Drag a point, draw a piece anew."
      : "Draw over it with mouse or finger.";
    this.show(this.studio.time);
  }

  #line = (points) =>
    points
      .map(
        ([share, value], i) =>
          `${i ? "L" : "M"}${this.axes.x(share).toFixed(2)} ${this.axes.y(value).toFixed(2)}`,
      )
      .join("");

  #handle([share, value], i) {
    const frame = Math.round(share * this.axes.last);
    return s("circle", {
      class: "handle",
      cx: this.axes.x(share),
      cy: this.axes.y(value),
      r: 4.5,
      tabindex: 0,
      role: "slider",
      "data-point": i,
      "aria-label": `Point ${i + 1}, frame ${frame}`,
      "aria-valuemin": this.axes.low,
      "aria-valuemax": this.axes.high,
      "aria-valuenow": value,
      keydown: (event) => this.#key(event, i),
    });
  }

  show(time) {
    this.now?.setAttribute("transform", `translate(${this.axes.frameX(time)} 0)`);
  }

  #key(event, i) {
    const points = this.#points.map((point) => [...point]);
    const by = (this.axes.high - this.axes.low) / 40;
    const step = { ArrowUp: [0, by], ArrowDown: [0, -by], ArrowLeft: [-1, 0], ArrowRight: [1, 0] }[
      event.key
    ];
    if (step) {
      points[i][1] = clamp(points[i][1] + step[1], this.axes.low, this.axes.high);
      points[i][0] = this.#between(points, i, points[i][0] + step[0] / Math.max(this.axes.last, 1));
    } else if ((event.key === "Delete" || event.key === "Backspace") && points.length > 2)
      points.splice(i, 1);
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.#points = points;
    this.#show();
    this.#sendSoon(points);
  }

  /** A share of the film between a point's neighbours. */
  #between(points, i, share) {
    const least = 0.5 / Math.max(this.axes.last, 1);
    const low = i ? points[i - 1][0] + least : 0;
    const high = i < points.length - 1 ? points[i + 1][0] - least : 1;
    return clamp(share, low, high);
  }

  #draw(event) {
    if (event.button !== 0 || !(this.#expression || this.#range)) return;
    event.preventDefault();
    const { svg, axes } = this;
    const scale = svg.getScreenCTM().a; // pixels to a unit of the plot
    const here = (next) => {
      const [x, y] = pointIn(svg, next);
      return [axes.shareAt(x), axes.valueAt(y)];
    };
    const old = this.#points ?? [];
    const [x, y] = pointIn(svg, event);
    const held = old.findIndex(
      ([share, value]) => Math.hypot(axes.x(share) - x, axes.y(value) - y) * scale < REACH,
    );
    const target = svg.querySelector(".target");
    const stroke = [];
    let points = old;
    const move = (next) => {
      const [share, value] = here(next);
      if (held >= 0) {
        points = old.map((point) => [...point]);
        points[held] = [this.#between(points, held, share), value];
        svg.querySelector(`[data-point="${held}"]`).setAttribute("cx", axes.x(points[held][0]));
        svg.querySelector(`[data-point="${held}"]`).setAttribute("cy", axes.y(value));
      } else {
        for (const each of next.getCoalescedEvents?.() ?? []) stroke.push(here(each));
        stroke.push([share, value]);
        points = redrawn(old, stroke);
      }
      target.setAttribute("d", this.#line(points));
    };
    this.#drawing = true;
    if (held < 0) move(event);
    follow(svg, event, move, (_, broken) => {
      this.#drawing = false;
      if (broken || (held < 0 && stroke.length < 4) || points === old) {
        this.#show();
        return;
      }
      this.#send(points);
    });
  }

  #sendSoon = later((points) => this.#send(points), 300); // many keys are one step

  async #send(points) {
    const rounded = points.map(([share, value]) => [
      Number(share.toFixed(3)),
      Number(value.toFixed(3)),
    ]);
    this.#points = rounded;
    this.#show();
    const { low, high } = this.axes;
    await this.studio.byHand("i2p/curve", {
      points: rounded,
      range: this.#range,
      expression: this.#expression,
      low,
      high,
    });
  }
}
