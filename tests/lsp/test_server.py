"""`stlc lsp` as an editor meets it: a client over standard input and output."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient

from stlc.lsp import server

TEXT = """# a mission – with a dash
step 500 ms
workspace box [0, 10] x [0, 10]
param far = 8 m
agent r1 : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
region dock = box [8, 9] x [8, 9]
let home(a, g) = eventually[0, 16] a in g
require reach: home(r1, dock) and eventually[2, 8] r1.x >= 2 m
require low: always forall a in agents: a.y <= far
minimize effort
"""

LIMIT = 60.0


class Editor:
    """A client with one open document."""

    def __init__(self, client: Any, uri: str) -> None:
        self.client, self.uri = client, uri
        self.told: asyncio.Queue[types.PublishDiagnosticsParams] = asyncio.Queue()

    @property
    def document(self) -> types.TextDocumentIdentifier:
        return types.TextDocumentIdentifier(self.uri)

    def at(self, text: str, needle: str, inside: int = 0) -> types.Position:
        """The position of a text, in UTF-16 units."""
        where = text.index(needle) + inside
        line = text.count("\n", 0, where)
        before = text[text.rfind("\n", 0, where) + 1 : where]
        return types.Position(line, len(before.encode("utf-16-le")) // 2)

    async def open(self, text: str) -> list[types.Diagnostic]:
        item = types.TextDocumentItem(self.uri, "stlc", 1, text)
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        return await self.diagnostics()

    async def diagnostics(self) -> list[types.Diagnostic]:
        return list((await asyncio.wait_for(self.told.get(), LIMIT)).diagnostics)


def edited(folder: Path, use: Callable[[Editor], Awaitable[None]]) -> None:
    """Start a server, use it, shut it down: it ends with status 0."""

    async def run() -> None:
        client: Any = LanguageClient("editor", "1")
        editor = Editor(client, (folder / "m.stl").as_uri())

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def tell(params: types.PublishDiagnosticsParams) -> None:
            editor.told.put_nowait(params)

        code = "import sys; sys.argv = ['stlc', 'lsp']; from stlc.cli import main; main()"
        await client.start_io(sys.executable, "-c", code)
        await client.initialize_async(
            types.InitializeParams(types.ClientCapabilities(), root_uri=folder.as_uri())
        )
        client.initialized(types.InitializedParams())
        await asyncio.wait_for(use(editor), LIMIT)
        await client.shutdown_async(None)
        client.exit(None)
        assert await asyncio.wait_for(client._server.wait(), LIMIT) == 0
        await client.stop()

    asyncio.run(run())


def test_diagnostics_follow_the_text_and_mends_are_offered(tmp_path: Path) -> None:
    async def use(editor: Editor) -> None:
        assert await editor.open(TEXT) == []
        wrong = TEXT.replace("home(r1, dock)", "home(r1, dok)")
        change = types.TextDocumentContentChangeWholeDocument(wrong)
        editor.client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(2, editor.uri), [change]
            )
        )
        (mistake,) = await editor.diagnostics()
        assert mistake.code == "E0201"
        assert mistake.severity is types.DiagnosticSeverity.Error
        assert mistake.range.start == editor.at(wrong, "dok)")
        assert "did you mean `dock`" in mistake.message
        (mend,) = await editor.client.text_document_code_action_async(
            types.CodeActionParams(editor.document, mistake.range, types.CodeActionContext([]))
        )
        (edit,) = mend.edit.changes[editor.uri]
        assert (edit.new_text, edit.range) == ("dock", mistake.range)
        editor.client.text_document_did_close(types.DidCloseTextDocumentParams(editor.document))
        assert await editor.diagnostics() == []

    edited(tmp_path, use)


def test_hover(tmp_path: Path) -> None:
    async def use(editor: Editor) -> None:
        await editor.open(TEXT)

        async def told(needle: str, inside: int = 0) -> str:
            where = editor.at(TEXT, needle, inside)
            found = await editor.client.text_document_hover_async(
                types.HoverParams(editor.document, where)
            )
            return "" if found is None else found.contents.value

        agent = await told("r1, dock")
        assert "agent r1 : double_integrator" in agent
        assert "- `ux` [m/s^2] from -1 to 1" in agent
        assert "region dock = box" in await told("dock) and")
        assert "let home(a, g)" in await told("home(r1")
        assert "position along x" in await told("r1.x", 3)
        assert "bound in line 9" in await told("a.y")
        assert "`always[a, b] p`" in await told("always")
        assert await told("8 m") == ""

    edited(tmp_path, use)


def test_completion(tmp_path: Path) -> None:
    text = TEXT + "require more: eventually r1.\nrequire last: \nagent r2 : \n"
    text += "channel c {\n  \n}\nre\n"

    async def use(editor: Editor) -> None:
        await editor.open(TEXT)
        editor.client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(2, editor.uri),
                [types.TextDocumentContentChangeWholeDocument(text)],
            )
        )

        async def offered(needle: str, inside: int) -> dict[str, str | None]:
            where = editor.at(text, needle, inside)
            found = await editor.client.text_document_completion_async(
                types.CompletionParams(editor.document, where)
            )
            return {item.label: item.detail for item in found}

        members = await offered("r1.\n", 3)
        assert members["vx"] == "state [m/s]"
        assert members["ux"] == "input [m/s^2]"
        assert "position" in members
        assert "dock" not in members
        names = await offered("last: ", 6)
        assert {"r1", "dock", "home", "far", "always", "rssi"} <= set(names)
        kinds = await offered("agent r2 : ", 11)
        assert set(kinds) == {"car", "double_integrator", "single_integrator", "unicycle"}
        assert "path_loss" in await offered("channel c {\n  ", 14)
        assert "require" in await offered("}\nre\n", 4)
        assert await offered("# a mission", 5) == {}

    edited(tmp_path, use)


def test_definition_references_and_rename(tmp_path: Path) -> None:
    (tmp_path / "lib.stl").write_text("region far_dock = box [1, 2] x [1, 2]\n")
    text = 'import "lib.stl"\n' + TEXT + "require other: eventually r1 in far_dock\n"

    async def use(editor: Editor) -> None:
        assert await editor.open(text) == []
        client, document = editor.client, editor.document
        found = await client.text_document_definition_async(
            types.DefinitionParams(document, editor.at(text, "dock) and"))
        )
        assert found.range.start == editor.at(text, "dock = box")
        bound = await client.text_document_definition_async(
            types.DefinitionParams(document, editor.at(text, "a.y"))
        )
        assert bound.range.start == editor.at(text, "a in agents")
        elsewhere = await client.text_document_definition_async(
            types.DefinitionParams(document, editor.at(text, "far_dock"))
        )
        assert elsewhere.uri == (tmp_path / "lib.stl").as_uri()
        assert elsewhere.range.start == types.Position(0, 7)
        uses = await client.text_document_references_async(
            types.ReferenceParams(
                types.ReferenceContext(include_declaration=False), document, editor.at(text, "r1 :")
            )
        )
        places = [editor.at(text, n) for n in ("r1, dock", "r1.x", "r1 in far_dock")]
        assert [u.range.start for u in uses] == places
        edit = await client.text_document_rename_async(
            types.RenameParams(document, editor.at(text, "a in g"), "who")
        )
        starts = [e.range.start for e in edit.changes[editor.uri]]
        assert starts == [editor.at(text, "a, g)"), editor.at(text, "a in g")]
        for name, where in (("1x", "dock = box"), ("r1", "dock = box"), ("x", "far_dock")):
            with pytest.raises(JsonRpcException):
                await client.text_document_rename_async(
                    types.RenameParams(document, editor.at(text, where), name)
                )

    edited(tmp_path, use)


def test_format_hints_and_outline(tmp_path: Path) -> None:
    text = TEXT.replace("param far = 8 m", "param   far=8 m")

    async def use(editor: Editor) -> None:
        await editor.open(text)
        client, document = editor.client, editor.document
        options = types.FormattingOptions(tab_size=2, insert_spaces=True)
        (edit,) = await client.text_document_formatting_async(
            types.DocumentFormattingParams(document, options)
        )
        assert edit.new_text == TEXT
        whole = types.Range(types.Position(0, 0), types.Position(20, 0))
        hints = await client.text_document_inlay_hint_async(types.InlayHintParams(document, whole))
        assert [(h.position.line, h.label) for h in hints] == [
            (1, " horizon 16 steps, 8 s"), (6, " 0..8 s"), (7, " 1..4 s"),
        ]  # fmt: skip
        outline = await client.text_document_document_symbol_async(
            types.DocumentSymbolParams(document)
        )
        assert [s.name for s in outline] == ["far", "r1", "dock", "home", "reach", "low"]

    edited(tmp_path, use)


class Typed:
    """What the features see of a server: a text that changes, and what is published."""

    def __init__(self, text: str) -> None:
        self.workspace, self.source, self.version = self, text, 1

    def get_text_document(self, uri: str) -> Typed:
        return self


def test_questions_between_keys_do_not_wait_for_a_check(monkeypatch: pytest.MonkeyPatch) -> None:
    checks = []
    whole = server.read_document
    monkeypatch.setattr(server, "read_document", lambda *a: checks.append(a) or whole(*a))
    typed = Typed(TEXT)
    features = server.Features(typed)
    features.checked("m.stl")
    typed.source += "require more: eventually r1.x >= 3 m\n"
    assert "more" in features.document("m.stl").index.declarations
    assert features.document("m.stl").mission is not None
    assert len(checks) == 1
    features.checked("m.stl")
    assert len(checks) == 2
    assert features.document("m.stl") is features.checked("m.stl")
