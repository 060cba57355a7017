"""Units in which a formula's robustness may come out."""

from __future__ import annotations

from collections.abc import Iterable

from stlc.ir.nodes import Linear, Link, Node, Quantity, walk


def units_in(formulas: Iterable[Node]) -> set[str]:
    """Units of all predicates."""
    found: set[str] = set()
    seen: set[Node] = set()
    for formula in formulas:
        for node in walk(formula):
            if node in seen or not isinstance(node, Linear | Link):
                continue
            seen.add(node)
            found.add(node.unit if isinstance(node, Linear) else link_unit(node))
    return found


def link_unit(node: Link) -> str:
    """dB for strengths, ratios and their chance forms; rates, ratios and costs have none."""
    decibels = node.quantity in (Quantity.RSSI, Quantity.SNR)
    return "dB" if decibels or node.probability is not None else ""
