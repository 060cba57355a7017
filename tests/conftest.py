"""Hypothesis profiles, and which tests are slow.

The profile `ci` is reduced, `full` gives the figures of `make test-full`.
"""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

_QUIET = [HealthCheck.too_slow, HealthCheck.data_too_large]

settings.register_profile(
    "ci", max_examples=25, deadline=None, derandomize=True, suppress_health_check=_QUIET
)
settings.register_profile("full", max_examples=500, deadline=None, suppress_health_check=_QUIET)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Processes of their own, whole searches, quadratures: a third of the tests, nine tenths of the
# processor time.
SLOW = (
    "backends/test_race.py", "bench", "cli", "docs", "explain/test_planted",
    "explain/test_repair", "front/test_plan", "lsp/test_server", "milp/tables", "missions",
    "plot/test_panels", "preferences/test_brute_force", "radio/test_averages",
    "radio/test_directed", "renew/test_giving_up", "renew/test_links_and_tubes",
    "renew/test_receding", "renew/test_replanning", "solve/bounders", "solve/crew",
    "solve/routes/test_play", "solve/routes/test_visits", "solve/test_caps",
    "solve/test_link_kinds", "solve/test_link_search", "solve/test_neighbourhoods",
    "solve/test_several", "solve/test_turns", "sweep/test_sweep", "syntax/test_limits",
    "test_wheel.py", "verify/test_continuous_truth", "verify/test_definition",
    "verify/test_peers",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as `slow` what lies in a slow place; single tests bear the mark themselves."""
    here = Path(__file__).parent
    for item in items:
        if item.path.relative_to(here).as_posix().startswith(SLOW):
            item.add_marker(pytest.mark.slow)
