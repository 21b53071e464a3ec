// A stretch of frames that is marked on the time line, and what shall hold in it.
import { clamp, fill, h } from "./dom.js";

const USUAL = 8; // a film has so many stretches of the usual length
const AS_IT_IS = "=";

export class During {
  #number = 0;

  constructor(host, studio) {
    this.studio = studio;
    const number = (label) =>
      h("input", { type: "number", "aria-label": label, min: 1, required: true, input: this.#ask });
    this.first = number("First frame");
    this.last = number("Last frame");
    this.choice = h("select", { "aria-label": "What shall hold", change: () => this.#chosen() });
    this.own = h("input", {
      "aria-label": "A condition of your own",
      placeholder: "a condition …",
      spellcheck: "false",
      autocomplete: "off",
    });
    this.node = h(
      "form",
      { class: "during", hidden: true, submit: (event) => this.#say(event) },
      h("label", {}, "Frames ", this.first),
      h("label", {}, "to ", this.last),
      this.choice,
      this.own,
      h("button", { type: "submit", class: "main-button" }, "Pin"),
      h("button", { type: "button", class: "quiet", click: () => this.close() }, "Cancel"),
    );
    this.node.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close();
      event.stopPropagation();
    });
    host.append(this.node);
  }

  /** The frames that are marked; null where nothing is. */
  get frames() {
    if (this.node.hidden) return null;
    return [Number(this.first.value), Number(this.last.value)];
  }

  open(first = Math.max(1, this.studio.frame), last = null) {
    const end = this.studio.film.play.last;
    this.first.max = this.last.max = end;
    this.first.value = clamp(first, 1, end);
    this.last.value = clamp(last ?? first + Math.round(end / USUAL), 1, end);
    this.node.hidden = false;
    this.#ask();
    this.choice.focus();
  }

  close() {
    this.node.hidden = true;
    this.marked?.();
  }

  #ask = async () => {
    const number = ++this.#number;
    this.marked?.();
    const [first, last] = this.frames;
    if (!this.node.checkValidity() || first > last) return;
    const film = this.studio.film;
    const reply = await this.studio.ask("i2p/during", { first, last }, film);
    if (number !== this.#number || !reply) return;
    const before = this.choice.value;
    const share = (now, text) =>
      / [<>]= /.test(text) ? `now ${Number(now.toPrecision(2))}` : `now ${Math.round(100 * now)} %`;
    const can = this.studio.story?.can.hold;
    fill(
      this.choice,
      can ? h("option", { value: AS_IT_IS }, "all as it is now") : null,
      reply.offers.map(({ text, about, now }) =>
        h("option", { value: text, title: about }, `${text}  (${share(now, text)})`),
      ),
      h("option", { value: "" }, "something else …"),
    );
    const isThere = [...this.choice.options].some(({ value }) => value === before);
    if (before && isThere) this.choice.value = before;
    this.#chosen();
  };

  #chosen() {
    this.own.hidden = this.choice.value !== "";
    this.own.required = !this.own.hidden;
  }

  async #say(event) {
    event.preventDefault();
    const [first, last] = this.frames;
    const condition = this.choice.value || this.own.value.trim();
    if (first > last || !condition) return;
    const film = this.studio.film.id;
    const done =
      condition === AS_IT_IS
        ? this.studio.byHand("i2p/hold", { film, first, last })
        : this.studio.byHand("i2p/say", { first, last, condition });
    if (await done) this.close();
  }
}
