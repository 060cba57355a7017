"""Past operators: known well enough to say what to write instead."""

from __future__ import annotations

from typing import Final

from stlc.diagnostics import Diagnostic
from stlc.source import Span
from stlc.syntax.errors import PastOperator

_ONCE: Final = (
    "say it forward: `eventually` before the moment in question; for `always (q implies once p)` "
    "write `not q until p`"
)
_HISTORICALLY: Final = "say it forward: `always[a, b]` over the steps before the moment in question"
_SINCE: Final = "say it forward with `until`: what holds since p holds from p on"
_PREVIOUSLY: Final = "say it forward: use `next` for the later of the two steps"

_ADVICE: Final = {
    "once": _ONCE, "O": _ONCE, "historically": _HISTORICALLY, "H": _HISTORICALLY,
    "hist": _HISTORICALLY,
    "since": _SINCE, "S": _SINCE,
    "previously": _PREVIOUSLY, "previous": _PREVIOUSLY, "prev": _PREVIOUSLY,
    "yesterday": _PREVIOUSLY, "Y": _PREVIOUSLY, "P": _ONCE,
}  # fmt: skip

PAST: Final = frozenset(_ADVICE)
# Too long to be a signal's name by accident; short ones may be functions or signals.
PAST_WORDS: Final = frozenset({"once", "historically", "since", "previously"})


def past_operator(span: Span) -> Diagnostic:
    """The mistake of using the past operator at the span."""
    return PastOperator(span=span, word=span.text, advice=_ADVICE[span.text])
