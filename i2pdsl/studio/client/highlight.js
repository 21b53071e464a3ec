// Colours of stories and worlds, by the TextMate grammars that other editors use.
import { HighlightStyle, StreamLanguage, tags } from "./codemirror.js";

const KINDS = {
  "keyword.control": "keyword",
  "support.function": "function",
  "variable.language": "special",
  "keyword.operator.word": "keyword",
  "support.function.math": "function",
  "entity.name.function": "call",
  "variable.other.constant": "latent",
  "entity.name.type": "definition",
  "constant.language": "number",
  "constant.numeric": "number",
  "string.quoted.double": "string",
  "comment.line.number-sign": "comment",
  "string.unquoted": "map",
};
const TAGS = {
  keyword: tags.keyword,
  function: tags.function(tags.name),
  special: tags.special(tags.variableName),
  call: tags.function(tags.name),
  latent: tags.atom,
  definition: tags.definition(tags.name),
  number: tags.number,
  string: tags.string,
  comment: tags.comment,
  map: tags.monospace,
};

const kindOf = (scope) => KINDS[scope.slice(0, scope.lastIndexOf("."))] ?? null;

/** The pieces of a line, [{ end, kind }]: of the rules that match first, the first. */
function pieces(rules, line) {
  const found = [];
  for (let at = 0; at < line.length;) {
    let best = null;
    for (const rule of rules) {
      rule.pattern.lastIndex = at;
      const match = rule.pattern.exec(line);
      if (match && match[0] && (!best || match.index < best.match.index)) best = { rule, match };
    }
    if (!best) break;
    const { rule, match } = best;
    found.push({ end: match.index, kind: null });
    if (rule.captures) {
      Object.entries(rule.captures).forEach(([group, kind]) => {
        const [first, last] = match.indices[group];
        found.push({ end: first, kind: null }, { end: last, kind });
      });
    } else found.push({ end: match.index + match[0].length, kind: rule.kind });
    at = match.index + match[0].length;
  }
  return found;
}

export function languageOf(name, grammar) {
  const rules = grammar.patterns.map(({ match, name: scope, captures }) => ({
    pattern: new RegExp(match, "dg"),
    kind: scope && kindOf(scope),
    captures:
      captures &&
      Object.fromEntries(Object.entries(captures).map(([n, { name: s }]) => [n, kindOf(s)])),
  }));
  return StreamLanguage.define({
    name,
    startState: () => ({ line: [] }),
    copyState: (state) => ({ line: [...state.line] }),
    token(stream, state) {
      if (stream.sol()) state.line = pieces(rules, stream.string);
      while (state.line.length && state.line[0].end <= stream.pos) state.line.shift();
      if (!state.line.length) {
        stream.skipToEnd();
        return null;
      }
      const { end, kind } = state.line.shift();
      stream.pos = end;
      return kind;
    },
    tokenTable: TAGS,
    languageData: {
      commentTokens: { line: "#" },
      closeBrackets: { brackets: ["(", "[", "{", '"'] },
    },
  });
}

const colour = (name) => ({ color: `var(--text-${name})` });

export const colours = HighlightStyle.define([
  { tag: tags.keyword, ...colour("keyword"), fontWeight: "600" },
  { tag: tags.function(tags.name), ...colour("function") },
  { tag: tags.special(tags.variableName), ...colour("special") },
  { tag: tags.atom, ...colour("latent") },
  { tag: tags.definition(tags.name), ...colour("function"), fontWeight: "600" },
  { tag: tags.number, ...colour("number") },
  { tag: tags.string, ...colour("string") },
  { tag: tags.comment, ...colour("comment"), fontStyle: "italic" },
  { tag: tags.monospace, ...colour("special") },
]);
