"""`stlc lsp`: the features of the language server, over standard input and output (pygls)."""

from __future__ import annotations

import asyncio
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from stlc.lsp import convert
from stlc.lsp.completion import complete
from stlc.lsp.document import Document, glance, read_document
from stlc.lsp.hints import hints
from stlc.lsp.hover import hover
from stlc.lsp.index import Occurrence
from stlc.lsp.positions import offset, place, position
from stlc.syntax.printer import format_file
from stlc.version import __version__

QUIET = 0.15  # s without a key before a text is checked again: between keys of a fast typist

TURN = 1e-3  # s that a check keeps the interpreter while a question waits, some five times each

_NAME = re.compile(r"[^\W\d]\w*")


class Features:
    """What the server answers, with the documents that are open."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self._seen: dict[str, Document] = {}  # as it was last asked about
        self._checked: dict[str, Document] = {}

    # --- documents -----------------------------------------------------------------------

    def document(self, uri: str) -> Document:
        """The document as the editor has it now; while a text is typed, not checked yet."""
        text = self._server.workspace.get_text_document(uri).source
        for known in (self._checked.get(uri), self._seen.get(uri)):
            if known is not None and known.text == text:
                return known
        checked, seen = self._checked.get(uri), self._seen.get(uri)
        self._seen[uri] = found = glance(text, _path(uri), checked, seen)
        return found

    def checked(self, uri: str) -> Document:
        """The document as the editor has it now, checked."""
        text = self._server.workspace.get_text_document(uri).source
        before = self._checked.get(uri)
        if before is None or before.text != text:
            self._checked[uri] = before = read_document(text, _path(uri), before)
        return before

    async def opened(self, params: types.DidOpenTextDocumentParams) -> None:
        """Check at once."""
        await self._publish(params.text_document.uri)

    async def changed(self, params: types.DidChangeTextDocumentParams) -> None:
        """Check when no key has been pressed for a moment."""
        uri, version = params.text_document.uri, params.text_document.version
        await asyncio.sleep(QUIET)
        if self._server.workspace.get_text_document(uri).version == version:
            await self._publish(uri)

    async def saved(self, params: types.DidSaveTextDocumentParams) -> None:
        """What the file imports may have changed."""
        self._checked.pop(params.text_document.uri, None)
        await self._publish(params.text_document.uri)

    def closed(self, params: types.DidCloseTextDocumentParams) -> None:
        """Nothing is wrong any more."""
        uri = params.text_document.uri
        self._checked.pop(uri, None)
        self._seen.pop(uri, None)
        self._server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))

    async def _publish(self, uri: str) -> None:
        """Diagnostics, found beside the loop that answers; nothing if the text has gone on."""
        text = self._server.workspace.get_text_document(uri)
        found = await asyncio.get_running_loop().run_in_executor(None, self.checked, uri)
        if self._server.workspace.get_text_document(uri).version != text.version:
            return
        self._server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(
                uri, convert.diagnostics(found, uri), version=text.version
            )
        )

    # --- questions -----------------------------------------------------------------------

    def hover(self, params: types.HoverParams) -> types.Hover | None:
        """What is known of a word."""
        found = self.document(params.text_document.uri)
        said = hover(found, offset(found.source, params.position))
        if said is None:
            return None
        content = types.MarkupContent(types.MarkupKind.Markdown, said[0])
        return types.Hover(content, place(said[1]))

    def completion(self, params: types.CompletionParams) -> list[types.CompletionItem]:
        """Words that may stand here."""
        found = self.document(params.text_document.uri)
        return [convert.item(o) for o in complete(found, offset(found.source, params.position))]

    def definition(self, params: types.DefinitionParams) -> types.Location | None:
        """Where a name is declared, here or in an imported file."""
        uri = params.text_document.uri
        found = self.document(uri)
        one = found.index.at(offset(found.source, params.position))
        if one is None:
            return None
        for occurrence in found.index.same(one):
            if occurrence.declares:
                return types.Location(uri, place(occurrence.span))
        if one.owner is not None:
            return None
        for other in found.imports:
            for occurrence in other.index.occurrences:
                if occurrence.declares and occurrence.owner is None and occurrence.name == one.name:
                    return types.Location(other.path.as_uri(), place(occurrence.span))
        return None

    def references(self, params: types.ReferenceParams) -> list[types.Location]:
        """Everywhere that a name stands in this file."""
        uri = params.text_document.uri
        declared = params.context.include_declaration
        return [
            types.Location(uri, place(o.span))
            for o in self._same(uri, params.position) if declared or not o.declares
        ]  # fmt: skip

    def highlights(self, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
        """The same, for the editor to mark."""
        same = self._same(params.text_document.uri, params.position)
        return [types.DocumentHighlight(place(o.span)) for o in same]

    def _same(self, uri: str, at: types.Position) -> list[Occurrence]:
        found = self.document(uri)
        one = found.index.at(offset(found.source, at))
        return [] if one is None else found.index.same(one)

    def may_rename(self, params: types.PrepareRenameParams) -> types.Range | None:
        """The name itself, if this file declares it."""
        uri = params.text_document.uri
        found = self.document(uri)
        one = found.index.at(offset(found.source, params.position))
        if one is None or not any(o.declares for o in found.index.same(one)):
            return None
        return place(one.span)

    def rename(self, params: types.RenameParams) -> types.WorkspaceEdit:
        """All occurrences of a name that this file declares. An error for what is no name, or is
        another's already."""
        uri, new = params.text_document.uri, params.new_name
        same = self._same(uri, params.position)
        if not any(o.declares for o in same):
            raise JsonRpcInvalidParams("this file declares no such name")
        if not _NAME.fullmatch(new):
            raise JsonRpcInvalidParams(f"`{new}` is no name")
        if new in self.document(uri).index.declarations and new != same[0].name:
            raise JsonRpcInvalidParams(f"`{new}` is declared already")
        edits = [types.TextEdit(place(o.span), new) for o in same]
        return types.WorkspaceEdit(changes={uri: edits})

    def format(self, params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        """The file in the one style; nothing while there are mistakes of syntax."""
        found = self.document(params.text_document.uri)
        if not found.readable:
            return None
        new = format_file(found.pieces.result.file)
        if new == found.text:
            return []
        return [types.TextEdit(place(found.source.span(0, len(found.text))), new)]

    def hints(self, params: types.InlayHintParams) -> list[types.InlayHint]:
        """Remarks within the lines that are shown."""
        found = self.document(params.text_document.uri)
        first, last = (offset(found.source, at) for at in (params.range.start, params.range.end))
        placed = hints(found, first, last)
        return [types.InlayHint(position(found.source, at), text) for at, text in placed]

    def actions(self, params: types.CodeActionParams) -> list[types.CodeAction]:
        """Mends that diagnostics offer."""
        uri = params.text_document.uri
        return convert.fixes(self.document(uri), uri, params.range)

    def symbols(self, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        """Declarations, for the outline."""
        found = self.document(params.text_document.uri)
        return [
            types.DocumentSymbol(
                name, types.SymbolKind.Variable, place(declared.span), place(declared.name),
                detail=type(declared.statement).__name__.removesuffix("Decl").lower(),
            )
            for name, declared in found.index.declarations.items()
        ]  # fmt: skip


def _path(uri: str) -> Path | None:
    """The file of a document; None for one that is nowhere yet."""
    parts = urlparse(uri)
    return Path(unquote(parts.path)) if parts.scheme == "file" else None


def _plain(method: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A method as a function, which the server can mark."""
    if asyncio.iscoroutinefunction(method):

        async def later(params: Any) -> Any:
            return await method(params)

        return later

    def now(params: Any) -> Any:
        return method(params)

    return now


def make_server() -> Any:
    """A server with all features, not yet listening."""
    server: Any = LanguageServer("stlc", __version__)
    told = Features(server)
    triggers = types.CompletionOptions(trigger_characters=["."])
    renames = types.RenameOptions(prepare_provider=True)
    for name, handler, options in (
        (types.TEXT_DOCUMENT_DID_OPEN, told.opened, None),
        (types.TEXT_DOCUMENT_DID_CHANGE, told.changed, None),
        (types.TEXT_DOCUMENT_DID_SAVE, told.saved, None),
        (types.TEXT_DOCUMENT_DID_CLOSE, told.closed, None),
        (types.TEXT_DOCUMENT_HOVER, told.hover, None),
        (types.TEXT_DOCUMENT_COMPLETION, told.completion, triggers),
        (types.TEXT_DOCUMENT_DEFINITION, told.definition, None),
        (types.TEXT_DOCUMENT_REFERENCES, told.references, None),
        (types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT, told.highlights, None),
        (types.TEXT_DOCUMENT_PREPARE_RENAME, told.may_rename, None),
        (types.TEXT_DOCUMENT_RENAME, told.rename, renames),
        (types.TEXT_DOCUMENT_FORMATTING, told.format, None),
        (types.TEXT_DOCUMENT_INLAY_HINT, told.hints, None),
        (types.TEXT_DOCUMENT_CODE_ACTION, told.actions, None),
        (types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, told.symbols, None),
    ):
        server.feature(name, options)(_plain(handler))
    return server


def serve() -> None:
    """Answer on standard input and output until the editor leaves."""
    sys.setswitchinterval(TURN)
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:  # the server closes what it is given
        make_server().start_io(sys.stdin.buffer, out)
