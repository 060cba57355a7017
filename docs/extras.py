"""What the site needs beside Sphinx: formulas as MathML, the missions of `examples/`."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import Any, ClassVar
from xml.etree import ElementTree

from docutils import nodes
from docutils.parsers.rst import Directive
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
MADE = "_gallery"  # under docs: pictures and reports of this build


def drawn(text: str, display: str) -> str:
    """MathML of a formula. ExtensionError for what the converter doesn't know."""
    if "\\\\" in text and "\\begin" not in text:  # lines, as Sphinx's own writers have them
        text = f"\\begin{{split}}{text}\\end{{split}}"
    made = str(convert(text.replace("{aligned}", "{split}"), display=display))
    try:
        ElementTree.fromstring(made)
    except ElementTree.ParseError as error:
        raise ExtensionError(f"no MathML for {text}: {error}") from None
    return made


def inline_formula(writer: Any, node: nodes.math) -> None:
    """A formula within a line: browsers draw MathML by themselves, with no script from anywhere."""
    writer.body.append(drawn(node.astext(), "inline"))
    raise nodes.SkipNode


def block_formula(writer: Any, node: nodes.math_block) -> None:
    """A formula on lines of its own; a wide one scrolls."""
    made = drawn(node.astext(), "block")
    writer.body.append(f'<div style="overflow-x: auto">{made}</div>')
    raise nodes.SkipNode


class MissionDirective(Directive):
    """`mission NAME`: the plan's picture, a way to its report, and the text."""

    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        """The nodes."""
        name = self.arguments[0]
        picture = nodes.image(uri=f"{MADE}/{name}.png", alt=f"the plan of {name}")
        way = nodes.raw("", f'<p><a href="{name}.html">the plan in motion</a>: '
                        f"<code>stlc report examples/{name}.stl plan.json -o plan.html</code></p>",
                        format="html")  # fmt: skip
        text = (EXAMPLES / f"{name}.stl").read_text(encoding="utf-8")
        return [picture, way, nodes.literal_block(text, text, language="stl")]


def build_gallery(app: Any) -> None:
    """Pictures and reports of all missions; the build ends where a plan isn't one."""
    argv, sys.argv = sys.argv, ["gallery.py", str(DOCS / MADE)]
    try:
        status = runpy.run_path(str(EXAMPLES / "gallery.py"))["main"]()
    finally:
        sys.argv = argv
    if status:
        raise ExtensionError("a plan of the gallery does not satisfy its mission")


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_node(nodes.math, override=True, html=(inline_formula, None))
    app.add_node(nodes.math_block, override=True, html=(block_formula, None))
    app.add_directive("mission", MissionDirective)
    app.connect("builder-inited", build_gallery)
    return {"parallel_read_safe": True}
