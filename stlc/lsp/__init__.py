"""The language server: what an editor shows of a mission while it is written."""

from __future__ import annotations
