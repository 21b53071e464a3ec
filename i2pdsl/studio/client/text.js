// The story's text: CodeMirror, with what the language server says of it. The text is the truth:
// whatever is done by hand elsewhere comes here as an edit, and each is one step of undo.
import {
  Annotation,
  Compartment,
  EditorState,
  EditorView,
  Prec,
  Transaction,
  autocompletion,
  bracketMatching,
  closeBrackets,
  closeBracketsKeymap,
  completionKeymap,
  defaultKeymap,
  drawSelection,
  highlightActiveLine,
  history,
  historyKeymap,
  hoverTooltip,
  indentUnit,
  isolateHistory,
  keymap,
  lineNumbers,
  lintGutter,
  lintKeymap,
  redo,
  redoDepth,
  searchKeymap,
  setDiagnostics,
  snippet,
  syntaxHighlighting,
  tooltips,
  undo,
  undoDepth,
} from "./codemirror.js";
import { fetched, h, sheetOf } from "./dom.js";
import { colours, languageOf } from "./highlight.js";
import { numberAt, numbers, setNumbers, slider, stepNumber } from "./numbers.js";

const Hand = Annotation.define(); // what was not typed
const SEVERITIES = { 1: "error", 2: "warning", 3: "info", 4: "hint" };
const KINDS = {
  3: "function",
  6: "variable",
  7: "type",
  12: "constant",
  14: "keyword",
  21: "constant",
};
const grammars = {};

/** What colours a language; nothing where it cannot be had. */
async function grammarOf(language) {
  const ask = async () => (await fetch(`/language/${language}.tmLanguage.json`)).json();
  try {
    return languageOf(language, await fetched(grammars, language, ask));
  } catch {
    return [];
  }
}

export class Text {
  #view;
  #language = new Compartment();
  #dirty = false; // the server has another text
  #isTold = false; // the server knows the document

  /**
   * @param host the element that holds the editor
   * @param rpc the connection
   * @param changed called with {isHand} when a new version was sent
   */
  constructor(host, rpc, changed) {
    this.rpc = rpc;
    this.changed = changed;
    this.uri = null;
    this.version = 0;
    this.languageId = "story";
    // In a shadow root CodeMirror brings its style as a sheet, which the page's policy allows.
    const root = host.attachShadow({ mode: "open" });
    sheetOf("/text.css").then((sheet) => root.adoptedStyleSheets.push(sheet));
    this.#view = new EditorView({ parent: root, root, state: this.#state("") });
    rpc.on("textDocument/publishDiagnostics", (found) => this.#show(found));
  }

  get text() {
    return this.#view.state.doc.toString();
  }

  get canUndo() {
    return undoDepth(this.#view.state) > 0;
  }

  get canRedo() {
    return redoDepth(this.#view.state) > 0;
  }

  undo = () => undo(this.#view);
  redo = () => redo(this.#view);
  focus = () => this.#view.focus();

  /** Opens a document; what was open is closed. It is there at once; the language server hears of it
   * as soon as it is `ready`. */
  async open(uri, languageId, text, ready) {
    if (this.#isTold) {
      this.rpc.notify("textDocument/didClose", { textDocument: { uri: this.uri } });
    }
    this.uri = uri;
    this.languageId = languageId;
    this.version += 1;
    this.#dirty = this.#isTold = false;
    this.#view.setState(this.#state(text));
    const [language] = await Promise.all([grammarOf(languageId), ready()]);
    if (this.uri !== uri) return;
    this.#view.dispatch({ effects: this.#language.reconfigure(language) });
    this.announce();
  }

  /** Tells the server what is open: first, and after each time that it was lost. */
  announce() {
    if (this.uri === null) return;
    this.#dirty = false;
    this.#isTold = true;
    const { uri, version, languageId, text } = this;
    this.rpc.notify("textDocument/didOpen", { textDocument: { uri, languageId, version, text } });
    this.changed({ isHand: true });
  }

  /** Another text in place of all of this one, as a step that can be undone. */
  replace(text) {
    if (text === this.text) return;
    this.#byHand({ changes: { from: 0, to: this.#view.state.doc.length, insert: text } });
  }

  /** Makes the language server's edits of a version. False where that is not the present one. */
  apply({ version, edits }) {
    this.flush();
    if (version !== this.version) return false;
    const changes = edits.map(({ range, newText }) => ({ ...this.#span(range), insert: newText }));
    if (changes.length) this.#byHand({ changes, scrollIntoView: true });
    return true;
  }

  /** What the server knows of the numbers of a version. */
  setNumbers(version, found) {
    if (version !== this.version || this.#dirty) return;
    const placed = found.map(({ range, ...rest }) => ({ ...rest, ...this.#span(range) }));
    this.#view.dispatch({ effects: setNumbers.of(placed) });
  }

  /** Writes a number of a range anew. */
  rewrite(range, text) {
    this.#byHand({ changes: { ...this.#span(range), insert: text } });
  }

  /** Shows where something stands. */
  reveal(range) {
    const { from, to } = this.#span(range);
    this.revealAt(from, to);
  }

  revealAt(from, to) {
    this.#view.dispatch({ selection: { anchor: from, head: to }, scrollIntoView: true });
  }

  async format() {
    this.flush();
    const [version, textDocument] = [this.version, { uri: this.uri }];
    const options = { tabSize: 4, insertSpaces: true };
    const asked = this.rpc.request("textDocument/formatting", { textDocument, options });
    const edits = await asked.catch(() => null); // a text with mistakes stays as it is
    this.apply({ version, edits: edits ?? [] });
  }

  /** Whether the server knows the document, so that it can be asked about. */
  get isTold() {
    return this.#isTold;
  }

  /** The server was lost: the next one hears of the text by `announce`. */
  lost() {
    this.#isTold = false;
  }

  /** Sends the text if it has changed: before anything is asked about it. */
  flush() {
    if (!this.#dirty) return;
    this.#dirty = false;
    this.version += 1;
    if (this.#isTold) {
      this.rpc.notify("textDocument/didChange", {
        textDocument: { uri: this.uri, version: this.version },
        contentChanges: [{ text: this.text }],
      });
    }
    const isHand = this.#isHand;
    this.#isHand = false;
    this.changed({ isHand });
  }

  // ------------------------------------------------------------------ inside

  #isHand = false;

  #byHand(spec) {
    const annotations = [
      Hand.of(true),
      isolateHistory.of("full"),
      Transaction.userEvent.of("hand"),
    ];
    this.#view.dispatch({ ...spec, annotations });
  }

  #state(doc) {
    const language = "the story’s text";
    return EditorState.create({
      doc,
      extensions: [
        lineNumbers(),
        lintGutter(),
        history(),
        drawSelection(),
        highlightActiveLine(),
        bracketMatching(),
        closeBrackets(),
        indentUnit.of("    "),
        EditorState.tabSize.of(4),
        EditorView.lineWrapping,
        EditorView.contentAttributes.of({ "aria-label": language, spellcheck: "false" }),
        tooltips({ position: "fixed" }),
        this.#language.of([]),
        syntaxHighlighting(colours),
        numbers({ rewrite: this.#slide }),
        autocompletion({ override: [(context) => this.#complete(context)], icons: true }),
        hoverTooltip((view, at) => this.#hover(view, at), { hoverTime: 220 }),
        Prec.high(
          keymap.of([
            { key: "Shift-Alt-f", run: () => (this.format(), true) },
            { key: "Alt-ArrowUp", run: (view) => stepNumber(view, 1, this.#stepped) },
            { key: "Alt-ArrowDown", run: (view) => stepNumber(view, -1, this.#stepped) },
          ]),
        ),
        keymap.of([
          ...closeBracketsKeymap,
          ...completionKeymap,
          ...searchKeymap,
          ...lintKeymap,
          ...historyKeymap,
          ...defaultKeymap,
        ]),
        EditorView.updateListener.of((update) => this.#heard(update)),
      ],
    });
  }

  #heard(update) {
    if (!update.docChanged) return;
    this.#isHand ||= update.transactions.some((one) => one.annotation(Hand));
    if (this.#dirty) return;
    this.#dirty = true;
    queueMicrotask(() => this.flush()); // once for all that happens in a moment
  }

  #stepped = ({ from, to }, insert) => this.#byHand({ changes: { from, to, insert } });

  // What a slider writes from its first move until it is let go is one step: CodeMirror joins what
  // is composed, however long that takes, to the step before it.
  #slide = ({ from, to }, insert, phase) => {
    if (phase === "end") {
      this.#view.dispatch({ annotations: isolateHistory.of("full") });
      this.flush();
      this.changed({ isHand: true });
      return;
    }
    const annotations =
      phase === "begin"
        ? [isolateHistory.of("before"), Transaction.userEvent.of("hand")]
        : [Transaction.userEvent.of("input.type.compose")];
    this.#view.dispatch({ changes: { from, to, insert }, annotations });
  };

  #offset({ line, character }) {
    const { doc } = this.#view.state;
    if (line >= doc.lines) return doc.length;
    const { from, to } = doc.line(line + 1);
    return Math.min(from + character, to);
  }

  #span = ({ start, end }) => ({ from: this.#offset(start), to: this.#offset(end) });

  #position(at) {
    const line = this.#view.state.doc.lineAt(at);
    return { line: line.number - 1, character: at - line.from };
  }

  #show({ uri, version, diagnostics }) {
    if (uri !== this.uri || (version ?? this.version) !== this.version || this.#dirty) return;
    const found = diagnostics.map(({ range, severity, message }) => ({
      ...this.#span(range),
      severity: SEVERITIES[severity ?? 1],
      message,
    }));
    this.#view.dispatch(setDiagnostics(this.#view.state, found));
    this.mistakes = found.filter(({ severity }) => severity === "error").length;
    this.onDiagnostics?.(found);
  }

  #ask(method, at, more = {}) {
    this.flush();
    const about = { textDocument: { uri: this.uri }, position: this.#position(at), ...more };
    return this.rpc.request(method, about).catch(() => null); // no help where nobody is there
  }

  async #complete(context) {
    const typed = context.matchBefore(/[\w.]*$/);
    const before = context.state.sliceDoc(Math.max(context.pos - 1, 0), context.pos);
    if (!context.explicit && !/[\w(=[{|,:;@]/.test(before)) return null;
    const reply = await this.#ask("textDocument/completion", context.pos);
    const items = Array.isArray(reply) ? reply : (reply?.items ?? []);
    if (!items.length || context.aborted) return null;
    const range = items.find((item) => item.textEdit)?.textEdit.range;
    const sorted = [...items].sort((a, b) =>
      (a.sortText ?? a.label) < (b.sortText ?? b.label) ? -1 : 1,
    );
    return {
      from: range ? this.#offset(range.start) : (typed?.from ?? context.pos),
      options: sorted.map((item, rank) => this.#option(item, -Math.min(rank, 90))),
      validFor: /^\w*$/,
    };
  }

  #option(item, boost) {
    const text = item.textEdit?.newText ?? item.insertText ?? item.label;
    const told = item.documentation?.value ?? item.documentation;
    return {
      label: item.label,
      detail: item.detail ?? "",
      type: KINDS[item.kind] ?? "text",
      boost,
      info: told ? () => markdown(told) : undefined,
      apply: item.insertTextFormat === 2 ? snippet(text.replace(/\$(\d)/g, "$${$1}")) : text,
    };
  }

  async #hover(view, at) {
    const number = numberAt(view.state, at);
    const reply = await this.#ask("textDocument/hover", at);
    if (!reply && !number) return null;
    const told =
      reply &&
      [reply.contents]
        .flat()
        .map((part) => part.value ?? part)
        .join("\n\n");
    const { from, to } = number ?? (reply.range ? this.#span(reply.range) : { from: at, to: at });
    return {
      pos: from,
      end: to,
      above: true,
      create: () => ({
        dom: h(
          "div",
          { class: "hint" },
          number && slider(view, number, this.#slide),
          told && markdown(told),
        ),
      }),
    };
  }
}

/** The little of Markdown that the language server writes: fences, `code`, paragraphs. */
function markdown(text) {
  const parts = text.split(/^```\w*\n([\s\S]*?)^```$/m);
  return h(
    "div",
    { class: "told" },
    parts.map((part, i) => {
      if (i % 2) return h("pre", {}, part.trimEnd());
      return part
        .split(/\n\s*\n/)
        .filter((p) => p.trim())
        .map((paragraph) =>
          h(
            "p",
            {},
            paragraph.split(/(`[^`]+`|\*\*[^*]+\*\*)/).map((piece) => {
              if (/^`.*`$/s.test(piece)) return h("code", {}, piece.slice(1, -1));
              if (/^\*\*.*\*\*$/s.test(piece)) return h("strong", {}, piece.slice(2, -2));
              return piece;
            }),
          ),
        );
    }),
  );
}
