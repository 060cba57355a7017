"""Formulas travel between processes whose strings hash unlike."""

import os
import pickle
import subprocess
import sys

from stlc.ir.nodes import And, Const, Linear, Or, Role, Signal

NODE = And((Or((Linear(((Signal("r", Role.STATE, 0, 2), 1.5),), 1.0, "m"), Const(False))),))
ASK = """
import pickle, sys
from stlc.ir.nodes import And, Const, Linear, Or, Role, Signal
node = pickle.load(sys.stdin.buffer)
made = And((Or((Linear(((Signal("r", Role.STATE, 0, 2), 1.5),), 1.0, "m"), Const(False))),))
sys.exit(not (node == made and hash(node) == hash(made)))
"""


def test_a_formula_from_another_process_is_the_one_made_here() -> None:
    data = pickle.dumps(NODE)
    for seed in ("1", "2"):
        env = os.environ | {"PYTHONHASHSEED": seed}
        done = subprocess.run([sys.executable, "-c", ASK], input=data, env=env, check=False)
        assert done.returncode == 0
