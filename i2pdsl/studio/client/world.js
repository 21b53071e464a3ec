// A world's map, to be painted; who is in it; and drawings that are dropped on it.
import { fill, follow, h, s } from "./dom.js";
import { filmHost } from "./mounted.js";

const CELL = 100; // units of the drawing
const LARGEST = 2 ** 20; // bytes of a drawing

export class World {
  #told = null; // what `i2p/world` says of the present text
  #brush = null; // a symbol of the map
  #layer = null; // cells that are being painted

  constructor(host, studio) {
    this.studio = studio;
    this.host = host;
    this.screen = filmHost({ class: "screen map" });
    this.brushes = h("div", { class: "brushes", role: "radiogroup", "aria-label": "Paint with" });
    this.size = h("div", { class: "size" });
    this.cast = h("div", { class: "entities" });
    this.hint = h("p", { class: "hint" });
    host.append(this.screen, this.brushes, this.size, this.cast, this.hint);
    this.screen.addEventListener("pointerdown", (event) => this.#paint(event));
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
    this.svg.append(this.#layer);
    const paintable = told.can?.paint && told.map;
    this.brushes.hidden = this.size.hidden = !paintable;
    if (paintable) this.#listBrushes(told.map);
    this.#listCast(told.entities);
  }

  #listBrushes({ tiles, wall, free, rows }) {
    const all = [
      { name: "floor", symbol: free },
      { name: "wall", symbol: wall, color: "#6b4a3a" },
      ...tiles,
    ];
    this.#brush = all.some(({ symbol }) => symbol === this.#brush) ? this.#brush : wall;
    fill(
      this.brushes,
      all.map(({ name, symbol, color }) => {
        const swatch = h("i", { class: "swatch" });
        swatch.style.background = color ?? "#f5ead8";
        return h(
          "label",
          { class: "chip" },
          h("input", {
            type: "radio",
            name: "brush",
            value: symbol,
            checked: symbol === this.#brush,
            change: () => (this.#brush = symbol),
          }),
          swatch,
          name,
        );
      }),
    );
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

  #listCast(entities) {
    fill(
      this.cast,
      entities.map(({ name, what, color, sprite }) => {
        const dot = h("i", { class: "swatch" });
        if (color) dot.style.background = color;
        return h(
          "div",
          { class: "entity", "data-name": name, "data-what": what },
          dot,
          h(
            "button",
            {
              type: "button",
              class: "quiet",
              title: "Shows it in the text",
              click: () => this.studio.find(`${what} ${name}`),
            },
            h("strong", {}, name),
          ),
          h("small", {}, [what, sprite].filter(Boolean).join(", ")),
          h(
            "button",
            {
              type: "button",
              class: "quiet",
              title: `Takes ${name} out of the world`,
              "aria-label": `Remove ${name}`,
              click: () => this.studio.byHand("i2p/entity", { what, name, settings: null }),
            },
            "×",
          ),
        );
      }),
      this.#add(),
    );
  }

  #add() {
    const name = h("input", {
      required: true,
      pattern: "[A-Za-z]\\w*",
      placeholder: "name",
      "aria-label": "Name in the world",
      autocomplete: "off",
    });
    const what = h(
      "select",
      { "aria-label": "What it is" },
      ["character", "object", "tile"].map((each) => h("option", { value: each }, each)),
    );
    const add = (event) => {
      event.preventDefault();
      this.studio.byHand("i2p/entity", { what: what.value, name: name.value, settings: {} });
    };
    return h(
      "form",
      { class: "entity add", submit: add },
      what,
      name,
      h("button", { type: "submit", class: "quiet" }, "Add"),
    );
  }

  // ------------------------------------------------------------------ the brush

  #cell(event) {
    const matrix = this.svg.getScreenCTM().inverse();
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    const [column, row] = [Math.floor(x / CELL), Math.floor(y / CELL)];
    const { rows } = this.#told.map;
    return row >= 0 && row < rows.length && column >= 0 && column < rows[row].length
      ? [column, row]
      : null;
  }

  #paint(event) {
    if (event.button !== 0 || !this.#told?.can?.paint) return;
    event.preventDefault();
    const painted = new Map();
    const touch = (next) => {
      const cell = this.#cell(next);
      if (!cell || painted.has(cell.join())) return;
      painted.set(cell.join(), cell);
      this.#layer.append(
        s("rect", {
          class: "spot near",
          x: cell[0] * CELL,
          y: cell[1] * CELL,
          width: CELL,
          height: CELL,
        }),
      );
    };
    touch(event);
    follow(this.screen, event, touch, (_, broken) => {
      this.#layer.replaceChildren();
      if (broken || !painted.size) return;
      this.studio.byHand("i2p/paint", { cells: [...painted.values()], symbol: this.#brush });
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
