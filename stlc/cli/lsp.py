"""`stlc lsp`."""

from __future__ import annotations

import click

from stlc.errors import UsageError


@click.command("lsp")
def lsp_command() -> int:
    """Serve an editor over standard input and output (the Language Server Protocol).

    Diagnostics with mends, hover, completion, definition, references, rename, outline, formatting
    and inlay hints. It needs the package `pygls`.
    """
    try:
        import pygls  # noqa: F401
    except ImportError:
        raise UsageError("this needs a package: pip install 'stlc[lsp]'") from None
    from stlc.lsp.server import serve

    serve()
    return 0
