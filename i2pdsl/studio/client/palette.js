// The patterns of the libraries: found by words, filled with the words of the story's world.
import { h, later, prose } from "./dom.js";

/** What a documentation says first. */
const firstOf = (about) => about.split(/(?<=[.!?])\s|\n\s*\n/)[0];

export class Palette {
  #number = 0;

  constructor(host, studio) {
    this.studio = studio;
    this.words = h("input", {
      type: "search",
      placeholder: "seems to help, then hinders …",
      "aria-label": "What it shall be like, in words",
      input: later(() => this.search(), 120),
    });
    this.list = h("ul", { class: "patterns" });
    host.append(
      h("p", { class: "panel-head" }, this.words),
      h(
        "p",
        { class: "hint" },
        "Say what you want viewers to go through; the patterns that fit best come first.",
      ),
      this.list,
    );
  }

  setShown(shown) {
    this.shown = shown;
    if (shown && !this.list.children.length) this.search();
  }

  /** Another story, maybe of another world, was opened. */
  clear() {
    this.list.replaceChildren();
    if (this.shown) this.search();
  }

  async search() {
    const number = ++this.#number;
    const params = { uri: this.studio.text.uri, words: this.words.value };
    const reply = await this.studio.request("i2p/patterns", params);
    if (!reply || number !== this.#number) return;
    this.list.replaceChildren(...reply.patterns.map((pattern) => this.#card(pattern)));
  }

  #card({ name, about, signature, picture, slots }) {
    const fields = slots.map((slot, i) => this.#slot(name, slot, i));
    const use = (event) => {
      event.preventDefault();
      const given = fields
        .map(({ input }, i) => [slots[i].name, input.value.trim()])
        .filter(([, value]) => value);
      this.studio.byHand("i2p/pattern", { name, arguments: Object.fromEntries(given) });
    };
    return h(
      "li",
      {},
      h(
        "details",
        { name: "pattern" },
        h(
          "summary",
          {},
          picture
            ? h("img", { src: picture, alt: "", loading: "lazy", width: 120, height: 40 })
            : null,
          h("strong", {}, name.replaceAll("_", " ")),
          h("span", {}, prose(firstOf(about))),
        ),
        h(
          "form",
          { submit: use },
          h("p", { class: "signature" }, h("code", {}, signature)),
          h("p", { class: "hint" }, prose(about)),
          fields.map(({ node }) => node),
          h("button", { type: "submit", class: "main-button" }, "Wish for it"),
        ),
      ),
    );
  }

  #slot(pattern, { name, default: usual, about, offers }, i) {
    const list = `offers-${pattern}-${i}`;
    const input = h("input", {
      list,
      value: usual === null ? (offers[0] ?? "") : "",
      placeholder: usual ?? "",
      spellcheck: "false",
      autocomplete: "off",
      required: usual === null,
    });
    const node = h(
      "label",
      { class: "slot" },
      h("code", {}, name),
      input,
      h(
        "datalist",
        { id: list },
        offers.map((value) => h("option", { value })),
      ),
      about ? h("small", {}, prose(about)) : null,
    );
    return { node, input };
  }
}
