// A story's text in a plain box, with undo: what the widget of notebooks has instead of CodeMirror.
import { h, later } from "./dom.js";

const PAUSE = 350; // milliseconds without a key before the text counts
const MOST = 200; // steps of undo

export class PlainText {
  version = 1;
  #before = [];
  #after = [];

  /** `changed(isHand)` is called when there is another text. */
  constructor(host, uri, text, changed) {
    Object.assign(this, { uri, text, changed });
    this.box = h("textarea", {
      spellcheck: "false",
      "aria-label": "The story’s text",
      rows: Math.min(18, text.split("\n").length + 2),
      value: text,
      input: () => this.#typed(),
    });
    this.box.addEventListener("keydown", (event) => event.stopPropagation());
    this.#typed = later(() => this.flush(), PAUSE);
    host.append(this.box);
  }

  #typed;

  get canUndo() {
    return this.#before.length > 0;
  }

  get canRedo() {
    return this.#after.length > 0;
  }

  /** What was typed is the text now. */
  flush() {
    this.#typed.cancel();
    if (this.box.value !== this.text) this.#put(this.box.value, false);
  }

  #put(text, isHand) {
    this.#before = [...this.#before, this.text].slice(-MOST);
    this.#after = [];
    this.#is(text, isHand);
  }

  #is(text, isHand) {
    this.text = text;
    this.version += 1;
    if (this.box.value !== text) this.box.value = text;
    this.changed(isHand);
  }

  /** Somebody else wrote another text. */
  take(text) {
    if (text !== this.text) this.#put(text, true);
  }

  undo() {
    if (!this.canUndo) return;
    this.#after.push(this.text);
    this.#is(this.#before.pop(), true);
  }

  redo() {
    if (!this.canRedo) return;
    this.#before.push(this.text);
    this.#is(this.#after.pop(), true);
  }

  #offset({ line, character }) {
    const lines = this.text.split("\n").slice(0, line);
    return lines.reduce((sum, each) => sum + each.length + 1, 0) + character;
  }

  /** Makes edits of a version; false where that is no longer the present one. */
  apply({ version, edits }) {
    if (version !== this.version) return false;
    let text = this.text;
    const places = edits.map(({ range: { start, end }, newText }) => ({
      from: this.#offset(start),
      to: this.#offset(end),
      newText,
    }));
    for (const { from, to, newText } of places.sort((a, b) => b.from - a.from)) {
      text = text.slice(0, from) + newText + text.slice(to);
    }
    if (text !== this.text) this.#put(text, true);
    return true;
  }

  rewrite(range, newText) {
    this.apply({ version: this.version, edits: [{ range, newText }] });
  }

  reveal({ start, end }) {
    this.box.focus();
    this.box.setSelectionRange(this.#offset(start), this.#offset(end));
  }
}
