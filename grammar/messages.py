"""Every message about malformed text; where two fit one place, the earlier wins."""

from __future__ import annotations

from typing import Final

from stlc.grammar.declaration_messages import DECLARATIONS
from stlc.grammar.formula_messages import FORMULAS
from stlc.grammar.message import Message

MESSAGES: Final[tuple[Message, ...]] = (*FORMULAS, *DECLARATIONS)
