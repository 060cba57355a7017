"""The independent evaluator: it has met neither passes nor encoders, and judges runs alone."""

from __future__ import annotations

from stlc.verify.judge import verify
from stlc.verify.report import Report, Violation

__all__ = ["Report", "Violation", "verify"]
