"""The extension for Visual Studio Code starts the server that its settings name."""

from __future__ import annotations

import json
from pathlib import Path

from py_mini_racer import MiniRacer

from stlc import grammar

FOLDER = Path(grammar.__file__).parent / "vscode"
EDITOR = """
const exports = {}, told = [];
class LanguageClient {
  constructor(id, name, server, options) { told.push({ id, server, options }); }
  start() { told.push("start"); }
  stop() { told.push("stop"); }
}
const settings = { command: %s };
const modules = {
  "vscode": { workspace: { getConfiguration: (name) => ({ get: (key) => settings[key] }) } },
  "vscode-languageclient/node": { LanguageClient },
};
const require = (name) => modules[name];
"""


def test_the_extension_starts_the_server_and_ends_it() -> None:
    package = json.loads((FOLDER / "package.json").read_text())
    setting = package["contributes"]["configuration"]["properties"]["stlc.command"]
    engine = MiniRacer()
    engine.eval(EDITOR % json.dumps(setting["default"]))
    engine.eval(f"(() => {{ {(FOLDER / package['main']).read_text()} }})()")
    engine.eval("exports.activate(); exports.deactivate()")
    made, *later = json.loads(engine.eval("JSON.stringify(told)"))
    assert made["server"] == {"command": "stlc", "args": ["lsp"]}
    assert made["options"]["documentSelector"] == [{"language": "stlc"}]
    assert later == ["start", "stop"]
    assert "vscode-languageclient" in package["dependencies"]
