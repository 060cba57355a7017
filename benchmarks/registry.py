"""What is measured: suites of problems, as data."""

from stlc.bench.problem import Problem, Suite

_COST = ("two_agents_t8_link_cost.csv",)

SUITES = (
    Suite(
        "paper",
        "the paper's case and a small sibling, our tables against the paper's own encoding",
        (
            Problem("two_agents_t4", "two_agents_t4.stl", quick=True),
            Problem("two_agents_t8", "two_agents_t8.stl", _COST),
        ),
        ("auto", "literal-tight", "literal"),
    ),
)
