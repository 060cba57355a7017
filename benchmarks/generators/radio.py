"""Radio: two agents and a station; the channel as a cost, and as requirements of every kind."""

from __future__ import annotations

from generators.text import Box, apart, carts, channel, clock, comment, document, region

_FIELD: Box = (0, 10, 0, 10)
_KINDS = {
    0: ("link cost alone", (), "0.1 * effort + 0.9 * link_cost(radio, (r1, r2))"),
    1: (
        "a level held throughout",
        ("talk: always rssi(r1, r2) >= -43.5 dBm",),
        "effort",
    ),
    2: (
        "a bit error rate, some of the time",
        ("talk: always[2, {late}] (ber(r1, r2) <= 1e-3 or ber(r1, base) <= 1e-3)",),
        "effort",
    ),
    3: (
        "a chance to reach the station",
        ("report: eventually P(rssi(r1, base) >= -36 dBm) >= 0.95",),
        "effort",
    ),
    4: (
        "packets until the goal is reached, and link cost",
        ("talk: prr(r1, r2) >= 0.9 until[0, {steps}] r1 in goal1",),
        "0.5 * effort + 0.5 * link_cost(radio, (r1, r2))",
    ),
}


def radio(kind: int, steps: int, cells: int) -> str:
    """One of five kinds of mission (0: cost, 1: rssi, 2: ber, 3: chance, 4: prr and cost)."""
    what, talks, price = _KINDS[kind]
    heard = any("base" in talk for talk in talks)
    places = [
        *(["station base at (5, 0)"] if heard else []),
        region("goal1", (8, 9, 8, 9)),
        region("goal2", (1, 2, 8, 9)),
        "obstacle pillar = box [4, 6] x [4, 6]",
    ]
    wanted = [
        "reach1: eventually r1 in goal1",
        "reach2: eventually r2 in goal2",
        "clear: always forall a in agents: a outside pillar",
        *(talk.format(late=steps - 2, steps=steps) for talk in talks),
    ]
    return document(
        comment(f"Two agents cross, {steps} steps, {cells} x {cells} cells: {what}."),
        clock(steps, _FIELD),
        carts([(1, 1), (9, 1)]),
        places,
        channel(cells),
        [*(f"require {line}" for line in wanted), *apart(2, 0.5)],
        f"minimize {price}",
    )
