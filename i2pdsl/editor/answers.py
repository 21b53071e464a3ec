"""What the language server answers, in the protocol's words. Needs the extra `lsp`."""

from __future__ import annotations

from lsprotocol import types as lsp

from i2pdsl.editor.complete import complete
from i2pdsl.editor.definition import definition, file_of
from i2pdsl.editor.documents import Document
from i2pdsl.editor.hover import hover
from i2pdsl.editor.names import MOST_LOOKED_AT
from i2pdsl.editor.outline import blocks, headings, signature_at
from i2pdsl.editor.positions import Lines
from i2pdsl.errors import Diagnostic, Span

_KINDS = {
    "latent": lsp.CompletionItemKind.Variable,
    "value": lsp.CompletionItemKind.EnumMember,
    "character": lsp.CompletionItemKind.Class,
    "object": lsp.CompletionItemKind.Class,
    "place": lsp.CompletionItemKind.Constant,
    "predicate": lsp.CompletionItemKind.Function,
    "event": lsp.CompletionItemKind.Event,
    "action": lsp.CompletionItemKind.EnumMember,
    "pattern": lsp.CompletionItemKind.Function,
    "let": lsp.CompletionItemKind.Variable,
    "parameter": lsp.CompletionItemKind.Variable,
    "argument": lsp.CompletionItemKind.Property,
    "function": lsp.CompletionItemKind.Function,
    "constant": lsp.CompletionItemKind.Constant,
    "setting": lsp.CompletionItemKind.Property,
    "world": lsp.CompletionItemKind.Module,
    "library": lsp.CompletionItemKind.Module,
    "audience": lsp.CompletionItemKind.Module,
    "search": lsp.CompletionItemKind.Module,
    "form": lsp.CompletionItemKind.Operator,
    "reduction": lsp.CompletionItemKind.Operator,
    "story": lsp.CompletionItemKind.Keyword,
    "keyword": lsp.CompletionItemKind.Keyword,
}
_SIGNS = ("operator", "sign", "bracket")  # typed faster than chosen
_SYMBOLS = {
    "let": lsp.SymbolKind.Variable,
    "pattern": lsp.SymbolKind.Function,
    "world": lsp.SymbolKind.Module,
    "map": lsp.SymbolKind.Array,
    "tile": lsp.SymbolKind.Constant,
    "character": lsp.SymbolKind.Class,
    "object": lsp.SymbolKind.Class,
    "event": lsp.SymbolKind.Event,
    "maximize": lsp.SymbolKind.Operator,
    "minimize": lsp.SymbolKind.Operator,
}


def warm_up() -> None:
    """Reads the grammar and the standard library, so that the first answer comes at once."""
    from i2pdsl.language.scope import standard_library

    standard_library()


def _range(lines: Lines, start: int, end: int) -> lsp.Range:
    return lsp.Range(
        lsp.Position(*lines.position(start)), lsp.Position(*lines.position(max(start, end)))
    )


def _is_own(span: Span, document: Document) -> bool:
    return span.source.name in ("", document.name) and span.source.text == document.text


def _location(span: Span, document: Document) -> lsp.Location | None:
    """The place of a span, in this document or in another file."""
    if _is_own(span, document):
        return lsp.Location(document.uri, _range(document.lines, span.start, span.end))
    path = file_of(span)
    if path is None:
        return None
    lines = Lines(span.source.text, document.encoding)
    return lsp.Location(path.absolute().as_uri(), _range(lines, span.start, span.end))


# Diagnostics.


def diagnostics(document: Document) -> list[lsp.Diagnostic]:
    """The mistakes of a document with their codes, hints and notes."""
    return [_diagnostic(d, document) for d in document.diagnostics()]


def _diagnostic(problem: Diagnostic, document: Document) -> lsp.Diagnostic:
    """A mistake in another file is shown where this one leads to it."""
    related = []
    place = problem.span
    if not _is_own(place, document):
        own = [n.span for n in problem.notes if _is_own(n.span, document)]
        related.append((problem.message, place))
        place = own[0] if own else Span(document.source, 0, 0)
    related += [(note.message, note.span) for note in problem.notes]
    shown = [(m, _location(s, document)) for m, s in related if s is not place]
    message = f"{problem.message}\nhint: {problem.hint}" if problem.hint else problem.message
    wrong = problem.severity == "error"
    return lsp.Diagnostic(
        _range(document.lines, place.start, place.end),
        message,
        lsp.DiagnosticSeverity.Error if wrong else lsp.DiagnosticSeverity.Warning,
        code=problem.code,
        source="i2p",
        related_information=[
            lsp.DiagnosticRelatedInformation(location, message)
            for message, location in shown
            if location is not None
        ],
    )


# Completion, hover, definition.


def completions(document: Document, offset: int) -> lsp.CompletionList:
    """The words that can be written at a place; signs are quicker typed."""
    if document.is_world:
        return lsp.CompletionList(False, [])
    found = complete(document.text, offset, document.around)
    ranges: dict[tuple[int, int], lsp.Range] = {}
    items = []
    for number, completion in enumerate(c for c in found if c.kind not in _SIGNS):
        place = completion.start, completion.end
        if place not in ranges:
            ranges[place] = _range(document.lines, *place)
        items.append(
            lsp.CompletionItem(
                completion.text.removesuffix(" = "),
                kind=_KINDS[completion.kind],
                detail=completion.detail or None,
                documentation=completion.documentation or None,
                sort_text=f"{number:04}",
                filter_text=completion.text,
                text_edit=lsp.TextEdit(ranges[place], completion.text),
            )
        )
    cut = len(document.around.module.names) > MOST_LOOKED_AT  # more may follow when more is typed
    return lsp.CompletionList(cut, items)


def hover_of(document: Document, offset: int) -> lsp.Hover | None:
    """What is known of the word at a place."""
    found = None if document.is_world else hover(document.text, offset, document.around)
    if found is None:
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, found.markdown())
    return lsp.Hover(content, _range(document.lines, found.start, found.end))


def location_of(document: Document, offset: int) -> lsp.Location | None:
    """Where the name at a place is defined."""
    span = None if document.is_world else definition(document.text, offset, document.around)
    return _location(span, document) if span is not None else None


def signature_of(document: Document, offset: int) -> lsp.SignatureHelp | None:
    """The call around a place."""
    found = None if document.is_world else signature_at(document.text, offset, document.around)
    if found is None:
        return None
    parameters = [lsp.ParameterInformation(p) for p in found.parameters]
    information = lsp.SignatureInformation(
        found.signature, documentation=found.documentation or None, parameters=parameters
    )
    return lsp.SignatureHelp([information], 0, found.active)


# The whole document.


def edits(document: Document) -> list[lsp.TextEdit] | None:
    """What formatting changes: the whole text, or nothing."""
    text = document.formatted()
    if text is None:
        return None
    if text == document.text:
        return []
    return [lsp.TextEdit(_range(document.lines, 0, len(document.text)), text)]


def symbols(document: Document) -> list[lsp.DocumentSymbol]:
    """The statements of a story, or the blocks of a world."""
    found = blocks(document.source) if document.is_world else headings(document.source)
    return [
        lsp.DocumentSymbol(
            heading.name,
            _SYMBOLS.get(heading.kind, lsp.SymbolKind.Property),
            _range(document.lines, heading.span.start, heading.span.end),
            _range(document.lines, heading.name_span.start, heading.name_span.end),
        )
        for heading in found
        if heading.name
    ]
