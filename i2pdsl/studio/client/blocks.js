// The blocks of a world's file, each with what can be set in it: characters, objects, places, and
// numbers such as rewards. What is set is rewritten in the text.
import { fill, h } from "./dom.js";

const MADE_BY_MAP = new Set(["symbol"]); // what is painted is not typed here
const quoted = (value) => JSON.stringify(value);
const plain = (value) => (value ?? "").replace(/^"|"$/g, "");
const members = (value) =>
  (value ?? "")
    .replace(/[{}]/g, "")
    .split(",")
    .map((each) => each.trim())
    .filter(Boolean);

export class Blocks {
  #open = new Set(); // keys of blocks that are unfolded

  constructor(host, studio) {
    Object.assign(this, { host, studio });
  }

  show({ blocks, fields, entities, can }) {
    for (const node of this.host.querySelectorAll("details[open]")) {
      this.#open.add(`${node.dataset.what} ${node.dataset.name ?? ""}`); // opened a moment ago
    }
    const held = document.activeElement;
    const focused = this.host.contains(held) ? held.dataset.field : null;
    const typed = focused && held.matches("input:not([type=color])") ? held.value : null;
    const named = new Set(can.blocks);
    const known = blocks.filter(({ what }) => fields[what]?.length);
    const single = Object.keys(fields)
      .filter((what) => !named.has(what) && !["wall", "size"].includes(what))
      .map((what) => known.find((each) => each.what === what) ?? { what, name: "", settings: {} });
    const who = known.filter(({ what }) => named.has(what));
    const colors = new Map(entities.map(({ name, color, sprite }) => [name, { color, sprite }]));
    fill(
      this.host,
      h(
        "div",
        { class: "entities" },
        who.map((block) => this.#card(block, fields[block.what], colors.get(block.name))),
        this.#add(can.blocks),
      ),
      h("h3", {}, "What all of them go by"),
      h(
        "div",
        { class: "entities" },
        single.map((block) => this.#card(block, fields[block.what])),
      ),
    );
    const again = focused && this.host.querySelector(`[data-field="${CSS.escape(focused)}"]`);
    if (!again) return;
    if (typed !== null) again.value = typed; // what is being typed stays
    again.focus();
  }

  #set({ what, name }, key, value) {
    this.studio.byHand("i2p/entity", { what, name, settings: { [key]: value } });
  }

  #card(block, fields, look = {}) {
    const { what, name, settings } = block;
    const key = `${what} ${name}`;
    const dot = h("i", { class: "swatch" });
    dot.style.background = plain(settings.color) || look.color || "transparent";
    const toggle = (event) => {
      if (event.target.open) this.#open.add(key);
      else this.#open.delete(key);
    };
    return h(
      "details",
      {
        class: "entity",
        open: this.#open.has(key),
        toggle,
        "data-name": name || null,
        "data-what": what,
      },
      h(
        "summary",
        {},
        name ? dot : null,
        h("strong", {}, name || what),
        h("small", {}, [name ? what : null, look.sprite].filter(Boolean).join(", ")),
      ),
      h(
        "div",
        { class: "fields" },
        fields
          .filter((field) => !MADE_BY_MAP.has(field.key))
          .map((field) => this.#field(block, field)),
        name
          ? h(
              "p",
              { class: "acts" },
              h(
                "button",
                { type: "button", class: "quiet", click: () => this.studio.find(key) },
                "Show in the text",
              ),
              h(
                "button",
                {
                  type: "button",
                  class: "quiet",
                  title: `Takes ${name} out of the world`,
                  "aria-label": `Remove ${name}`,
                  click: () => this.studio.byHand("i2p/entity", { what, name, settings: null }),
                },
                "Remove",
              ),
            )
          : null,
      ),
    );
  }

  #field(block, { key, kind, choices, about }) {
    const value = block.settings[key];
    const id = `field-${block.what}-${block.name}-${key}`;
    const common = { "data-field": id, "aria-label": `${block.name || block.what}: ${key}` };
    const change = (make) => ({
      ...common,
      change: (event) => this.#set(block, key, make(event.target)),
    });
    let input;
    if (kind === "set") {
      const on = new Set(members(value));
      const others = choices.filter((each) => each !== block.name);
      input = h(
        "span",
        { class: "chips", role: "group", "aria-label": common["aria-label"] },
        others.map((each) =>
          h(
            "button",
            {
              type: "button",
              class: "chip",
              "data-field": `${id}-${each}`,
              "aria-pressed": String(on.has(each)),
              click: () => {
                if (!on.delete(each)) on.add(each);
                const all = others.filter((other) => on.has(other));
                this.#set(block, key, all.length ? `{${all.join(", ")}}` : "");
              },
            },
            each,
          ),
        ),
      );
    } else if (kind === "one") {
      const isText = key.endsWith("sprite");
      const now = isText ? plain(value) : (value ?? "");
      const all = [...new Set(["", ...(now ? [now] : []), ...choices])];
      input = h(
        "select",
        change(({ value: chosen }) => (isText && chosen ? quoted(chosen) : chosen)),
        all
          .filter((each) => isText || each !== block.name)
          .map((each) => h("option", { value: each, selected: each === now }, each || "as usual")),
      );
    } else if (kind === "color") {
      input = h("input", {
        ...change((of) => quoted(of.value)),
        type: "color",
        value: plain(value) || "#b8b0a2",
      });
    } else {
      input = h("input", {
        ...change((of) => of.value.trim()),
        value: value ?? "",
        inputmode: kind === "number" ? "decimal" : null,
        placeholder: kind === "place" ? "put it on the map" : "as usual",
        spellcheck: "false",
        autocomplete: "off",
      });
    }
    return h("label", { class: "field", title: about || null }, h("span", {}, key), input);
  }

  #add(named) {
    const name = h("input", {
      required: true,
      pattern: "[^\\W\\d]\\w*",
      placeholder: "name",
      "aria-label": "Name in the world",
      autocomplete: "off",
    });
    const what = h(
      "select",
      { "aria-label": "What it is" },
      named.map((each) => h("option", { value: each }, each)),
    );
    const add = (event) => {
      event.preventDefault();
      this.#open.add(`${what.value} ${name.value}`);
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
}
