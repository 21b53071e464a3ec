// A world's map, to be painted; who is in it; and drawings that are dropped on it.
import { Blocks } from "./blocks.js";
import { fill, follow, h, s } from "./dom.js";
import { filmHost } from "./mounted.js";

const CELL = 100; // units of the drawing
const NEAR_SIDE = 0.3; // of a cell: so near to a side that it is meant
const LARGEST = 2 ** 20; // bytes of a drawing

export class World {
  #told = null; // what `i2p/world` says of the present text
  #brush = null; // a sign of the map, a wall between cells, or who is put somewhere
  #layer = null; // cells that are being painted

  constructor(host, studio) {
    this.studio = studio;
    this.host = host;
    this.screen = filmHost({ class: "screen map" });
    this.brushes = h("div", { class: "brushes", role: "radiogroup", "aria-label": "Paint with" });
    this.size = h("div", { class: "size" });
    this.cast = h("div", {});
    this.blocks = new Blocks(this.cast, studio);
    this.hint = h("p", { class: "hint" });
    host.append(this.screen, this.brushes, this.size, this.cast, this.hint);
    this.screen.addEventListener("pointerdown", (event) => this.#press(event));
    host.addEventListener("dragover", (event) => event.preventDefault());
    host.addEventListener("drop", (event) => this.#dropped(event));
    studio.rpc.on("i2p/world", (told) => {
      if (told.uri === studio.text.uri && told.version === studio.text.version) this.show(told);
    });
  }

  clear() {
    this.#told = null;
    this.host.hidden = true;
  }

  show(told) {
    const isSame = this.#told?.version === told.version; // and only planned by now
    this.#told = told;
    if (!isSame) this.#drawn(told);
    this.hint.textContent = [
      told.can?.paint ? "Press and drag to paint." : "",
      told.planned ? "" : "It is planned before stories can be told in it.",
      "Drop an SVG or PNG on a name to draw it so.",
    ]
      .filter(Boolean)
      .join(" ");
    this.studio.worldShown(told);
  }

  #drawn(told) {
    this.host.hidden = false;
    const template = document.createElement("template");
    template.innerHTML = told.stage;
    const box = h("div", { class: "theatre mounted" }, template.content);
    this.screen.shadowRoot.replaceChildren(box);
    this.svg = box.querySelector("svg");
    const { width, height } = this.svg.viewBox.baseVal;
    this.screen.style.setProperty("--shape", width / height);
    this.#layer = s("g", { class: "hands" });
    this.svg.append(this.#placed(told), this.#layer);
    this.#listBrushes(told);
    this.size.hidden = !told.map;
    if (told.map) this.#listSizes(told.map);
    this.blocks.show(told);
  }

  /** Who has a place at first: the drawing shows nobody. */
  #placed({ entities, map, units }) {
    const { width, height } = this.svg.viewBox.baseVal;
    const r = map ? CELL / 3 : Math.min(width, height) / 28;
    const within = map ? 0.5 : 0; // the middle of a cell
    return s(
      "g",
      { class: "placed" },
      entities.map(({ name, color, at }) => {
        const place = at?.match(/-?[\d.]+/g)?.map(Number) ?? [];
        if (place.length !== 2 || !units) return null;
        const [x, y] = place.map((each, i) => (each + within - units[i][1]) / units[i][0]);
        return [
          s("circle", { cx: x, cy: y, r, fill: color ?? "#8a8f98" }),
          s("text", { x, y: y - 1.3 * r, "font-size": 0.7 * r, "text-anchor": "middle" }, name),
        ];
      }),
    );
  }

  #listBrushes({ map, can, entities, blocks, units }) {
    const paint = !can?.paint
      ? []
      : [
          { name: "floor", brush: `map ${map.free}` },
          { name: "wall", brush: `map ${map.wall}`, color: "#6b4a3a" },
          { name: "edge wall", brush: "edge", color: "#6b4a3a" },
          ...map.tiles.map(({ name, symbol, color }) => ({ name, brush: `map ${symbol}`, color })),
        ];
    const line = units && !map ? [{ name: "wall", brush: "line", color: "#7d6b5d" }] : [];
    const places = map ? [] : blocks.filter(({ what }) => what === "place");
    const put = (units ? [...entities, ...places] : []).map(({ name, what, color, settings }) => ({
      name,
      title: `Press where ${name} shall be`,
      brush: `put ${what} ${name}`,
      color: color ?? settings?.color?.replaceAll('"', ""),
    }));
    const all = [...paint, ...line, ...put];
    this.brushes.hidden = !all.length;
    const isThere = all.some(({ brush }) => brush === this.#brush);
    this.#brush = isThere ? this.#brush : (paint[1] ?? all[0])?.brush;
    const chip = ({ name, brush, color, title }) => {
      const swatch = h("i", { class: brush === "edge" || brush === "line" ? "swatch thin" : "swatch" });
      swatch.style.background = color ?? "#f5ead8";
      return h(
        "label",
        { class: "chip", title: title ?? null },
        h("input", {
          type: "radio",
          name: "brush",
          value: brush,
          checked: brush === this.#brush,
          change: () => (this.#brush = brush),
        }),
        swatch,
        name,
      );
    };
    fill(
      this.brushes,
      [...paint, ...line].map(chip),
      put.length ? h("span", { class: "put" }, "put") : null,
      put.map(chip),
    );
  }

  #listSizes({ rows }) {
    const [columns, count] = [Math.max(...rows.map((row) => row.length)), rows.length];
    const number = (label, value, size) =>
      h(
        "label",
        {},
        h("span", {}, label),
        h("input", {
          type: "number",
          min: 1,
          max: 40,
          value,
          change: (event) => this.studio.byHand("i2p/size", size(Number(event.target.value))),
        }),
      );
    fill(
      this.size,
      number("columns", columns, (value) => ({ columns: value, rows: count })),
      number("rows", count, (value) => ({ columns, rows: value })),
    );
  }

  // ------------------------------------------------------------------ the brush

  #point(event) {
    const matrix = this.svg.getScreenCTM().inverse();
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return [x, y];
  }

  #isCell = ([column, row]) => {
    const { rows } = this.#told.map;
    return row >= 0 && row < rows.length && column >= 0 && column < rows[row].length;
  };

  #cell(event) {
    const cell = this.#point(event).map((each) => Math.floor(each / CELL));
    return this.#isCell(cell) ? cell : null;
  }

  /** The two cells between which a point lies, if it is near their side. */
  #side(event) {
    const [x, y] = this.#point(event).map((each) => each / CELL);
    const [dx, dy] = [x - Math.round(x), y - Math.round(y)];
    if (Math.min(Math.abs(dx), Math.abs(dy)) > NEAR_SIDE) return null;
    const side =
      Math.abs(dx) < Math.abs(dy)
        ? [-1, 0].map((step) => [Math.round(x) + step, Math.floor(y)])
        : [-1, 0].map((step) => [Math.floor(x), Math.round(y) + step]);
    return side.every(this.#isCell) ? side : null;
  }

  #press(event) {
    if (event.button !== 0 || !this.#told || !this.#brush) return;
    event.preventDefault();
    const [kind, what, name] = this.#brush.split(" ");
    if (kind === "map") this.#paint(event, what);
    else if (kind === "edge") this.#wall(event);
    else if (kind === "line") this.#line(event);
    else this.#put(event, what, name);
  }

  #paint(event, symbol) {
    const painted = new Map();
    const touch = (next) => {
      const cell = this.#cell(next);
      if (!cell || painted.has(cell.join())) return;
      painted.set(cell.join(), cell);
      const [x, y] = cell.map((each) => each * CELL);
      this.#layer.append(s("rect", { class: "spot near", x, y, width: CELL, height: CELL }));
    };
    touch(event);
    follow(this.screen, event, touch, (_, broken) => {
      this.#layer.replaceChildren();
      if (broken || !painted.size) return;
      this.studio.byHand("i2p/paint", { cells: [...painted.values()], symbol });
    });
  }

  /** Walls between cells: put up from where none was, or taken away from where one was. */
  #wall(event) {
    const known = new Set(this.#told.map.walls.map((side) => side.join()));
    const sides = new Map();
    let wall = null;
    const touch = (next) => {
      const side = this.#side(next);
      if (!side || sides.has(side.join())) return;
      wall ??= !known.has(side.join());
      if (wall === known.has(side.join())) return;
      sides.set(side.join(), side);
      const [[a, b], [c]] = side;
      const d = a === c ? `M${a * CELL} ${(b + 1) * CELL}h${CELL}` : `M${c * CELL} ${b * CELL}v${CELL}`;
      this.#layer.append(s("path", { class: wall ? "side" : "side not", d }));
    };
    touch(event);
    follow(this.screen, event, touch, (_, broken) => {
      this.#layer.replaceChildren();
      if (broken || !sides.size) return;
      this.studio.byHand("i2p/side", { sides: [...sides.values()], wall });
    });
  }

  /** A point of the drawing as the file has places. */
  #place(event) {
    const at = this.#point(event).map((each, axis) => {
      const [scale, offset] = this.#told.units[axis];
      return scale * each + offset;
    });
    if (this.#told.map) {
      const cell = at.map(Math.floor);
      return this.#isCell(cell) ? cell : null;
    }
    return at.map((each) => Math.round(100 * Math.max(each, 0)) / 100);
  }

  #line(event) {
    const from = this.#place(event);
    const [x, y] = this.#point(event);
    let to = from;
    follow(
      this.screen,
      event,
      (next) => {
        to = this.#place(next);
        const [u, v] = this.#point(next);
        this.#layer.replaceChildren(s("path", { class: "side", d: `M${x} ${y}L${u} ${v}` }));
      },
      (_, broken) => {
        this.#layer.replaceChildren();
        if (broken || Math.hypot(to[0] - from[0], to[1] - from[1]) < 0.1) return;
        const points = `[(${from.join(", ")}), (${to.join(", ")})]`;
        const wall = { what: "wall", name: "", settings: { points }, another: true };
        this.studio.byHand("i2p/entity", wall);
      },
    );
  }

  #put(event, what, name) {
    const mark = s("circle", { class: "target", r: CELL / 6 });
    let at = null;
    const touch = (next) => {
      at = this.#place(next);
      const [cx, cy] = this.#point(next);
      mark.setAttribute("cx", cx);
      mark.setAttribute("cy", cy);
    };
    this.#layer.append(mark);
    touch(event);
    follow(this.screen, event, touch, (_, broken) => {
      this.#layer.replaceChildren();
      if (broken || !at) return;
      const key = this.#told.map ? "cell" : "at";
      this.studio.byHand("i2p/entity", { what, name, settings: { [key]: `(${at.join(", ")})` } });
    });
  }

  // ------------------------------------------------------------------ drawings

  async #dropped(event) {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    const entity = event.composedPath().find((node) => node.dataset?.name);
    if (!file) return;
    if (!entity) return this.studio.tell("Drop it on the name of a character or an object.");
    if (!/\.(svg|png)$/i.test(file.name) || file.size > LARGEST) {
      return this.studio.tell("A drawing is an SVG or a PNG of less than 1 MB.");
    }
    const bytes = new Uint8Array(await file.arrayBuffer());
    const data = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
    const folder = this.studio.files.path.replace(/[^/]*$/, "");
    const reply = await this.studio.request("i2p/upload", { path: `${folder}${file.name}`, data });
    if (!reply) return;
    const { name, what } = entity.dataset;
    this.studio.byHand("i2p/entity", {
      what,
      name,
      settings: { sprite: JSON.stringify(reply.sprite) },
    });
  }
}
