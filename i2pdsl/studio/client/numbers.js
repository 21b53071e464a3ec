// The numbers of a text that can be slid: underlined, with a slider where the cursor or the pointer
// is, and Alt with the arrow keys.
import { Decoration, EditorView, StateEffect, StateField, showTooltip } from "./codemirror.js";
import { clamp, h } from "./dom.js";

/** Sets what is known of numbers: [{from, to, value, low, high, step, what, frame}]. */
export const setNumbers = StateEffect.define();

const found = StateField.define({
  create: () => [],
  update(known, transaction) {
    let now = known;
    if (transaction.docChanged) {
      const { changes, state } = transaction;
      now = known
        .map((one) => ({
          ...one,
          from: changes.mapPos(one.from, -1),
          to: changes.mapPos(one.to, 1),
        }))
        .filter(({ from, to }) => from < to && isNumber(state.sliceDoc(from, to)));
    }
    for (const effect of transaction.effects) if (effect.is(setNumbers)) now = effect.value;
    return now;
  },
  provide: (field) =>
    EditorView.decorations.from(field, (known) =>
      Decoration.set(
        known.map(({ from, to }) => Decoration.mark({ class: "number" }).range(from, to)),
        true,
      ),
    ),
});

const isNumber = (text) => /^-?\d+(\.\d*)?$/.test(text);

/** The number at a place of the text. */
export const numberAt = (state, at) =>
  state.field(found, false)?.find(({ from, to }) => from <= at && at <= to) ?? null;

const written = (value, step) => {
  const digits = step >= 1 ? 0 : Math.ceil(-Math.log10(step) - 1e-9);
  return String(Number(value.toFixed(digits)));
};

/** One step up or down of the number at the cursor. */
export function stepNumber(view, by, rewrite) {
  const number = numberAt(view.state, view.state.selection.main.head);
  if (!number) return false;
  const value = Number(view.state.sliceDoc(number.from, number.to));
  rewrite(number, written(clamp(value + by * number.step, number.low, number.high), number.step));
  return true;
}

/** A slider that rewrites a number: `rewrite(number, text, phase)`, where the phase is "begin" with
 * the first move, then "move", and "end" when it is let go. */
export function slider(view, number, rewrite) {
  const { low, high, step, what } = number;
  const now = () => numberAt(view.state, number.from);
  const text = ({ from, to }) => view.state.sliceDoc(from, to);
  let moving = false;
  const shown = h("output", {}, text(number));
  const move = (event) => {
    const [at, value] = [now(), written(Number(event.target.value), step)];
    if (!at || text(at) === value) return;
    shown.textContent = value;
    rewrite(at, value, moving ? "move" : "begin");
    moving = true;
  };
  const end = () => {
    if (moving) rewrite(number, "", "end");
    moving = false;
  };
  const input = h("input", { type: "range", min: low, max: high, step, input: move, change: end });
  input.value = text(number); // once its ends are known
  return h("label", { class: "slide" }, h("span", {}, what), input, shown);
}

/** The extension: `rewrite` as in `slider`. */
export function numbers({ rewrite }) {
  const atCursor = showTooltip.compute([found, "selection"], (state) => {
    const { main } = state.selection;
    const number = main.empty ? numberAt(state, main.head) : null;
    return number && known(state, number);
  });
  // The same tooltip for the same place, so that a slider is not remade while it is dragged.
  let last = null;
  function known(state, { from }) {
    if (last?.pos !== from) {
      last = {
        pos: from,
        above: true,
        create: (view) => ({
          dom: h("div", { class: "hint" }, slider(view, numberAt(view.state, from), rewrite)),
        }),
      };
    }
    return last;
  }
  return [found, atCursor];
}
