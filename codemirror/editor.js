// What the studio's text.js uses of CodeMirror, and no more.
export {
  EditorState,
  StateEffect,
  StateField,
  Compartment,
  Annotation,
  Prec,
  Transaction,
} from "@codemirror/state";
export {
  EditorView,
  Decoration,
  WidgetType,
  ViewPlugin,
  keymap,
  lineNumbers,
  drawSelection,
  highlightActiveLine,
  highlightActiveLineGutter,
  hoverTooltip,
  showTooltip,
  tooltips,
} from "@codemirror/view";
export {
  defaultKeymap,
  history,
  historyKeymap,
  undo,
  redo,
  undoDepth,
  redoDepth,
  isolateHistory,
  indentWithTab,
} from "@codemirror/commands";
export {
  StreamLanguage,
  HighlightStyle,
  syntaxHighlighting,
  bracketMatching,
  indentUnit,
} from "@codemirror/language";
export {
  autocompletion,
  closeBrackets,
  closeBracketsKeymap,
  completionKeymap,
  snippet,
  startCompletion,
} from "@codemirror/autocomplete";
export { lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
export { searchKeymap, highlightSelectionMatches } from "@codemirror/search";
export { tags } from "@lezer/highlight";
