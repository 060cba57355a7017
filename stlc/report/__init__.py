"""A plan and its mission as one HTML page that needs nothing else: no network, no other file."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from stlc.files import write_atomic

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.plan import Plan

__all__ = ["report_page", "write_report"]


def report_page(mission: Mission, plan: Plan) -> str:
    """The page as text. Raises UsageError when the plan doesn't fit the mission."""
    from stlc.report.page import page

    return page(mission, plan)


def write_report(mission: Mission, plan: Plan, path: str | os.PathLike[str]) -> None:
    """Write `report_page`; OutputError when the file can't be written."""
    write_atomic(path, report_page(mission, plan))
