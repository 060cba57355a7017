"""Malformed samples and what to say about them.

A sample is parsed when a mistake of the same kind has to be explained: where the parser gets stuck
on the sample (its state and the terminal it can't use) is where the message applies. So a message
follows the grammar wherever it moves, and a test finds samples that have become valid. With
`any_token` the message applies to every terminal that the state can't use.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Message:
    """What is said where one of the samples gets stuck; `{found}` is the text found there."""

    samples: tuple[str, ...]
    what: str
    place: str
    advice: str
    any_token: bool = False
