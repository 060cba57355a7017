"""Plans that doubles can't judge are refused before anything overflows."""

import numpy as np
import pytest
from support.command import MISSION

from stlc.api import loads, verify
from stlc.errors import UsageError
from stlc.plan import make_plan


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [1e308, -1e16])
def test_numbers_beyond_doubles(value: float) -> None:
    mission = loads(MISSION)
    states = np.zeros((5, 4))
    states[1, 0] = value
    plan = make_plan(mission, {"a": states}, {"a": np.zeros((4, 2))})
    with pytest.raises(UsageError, match=r"numbers for a beyond 1e\+15"):
        verify(mission, plan)
