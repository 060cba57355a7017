"""What may become of a plan: runs and channels drawn many times over, requirements judged."""

from stlc.simulate.estimate import Estimate, Simulation
from stlc.simulate.simulation import simulate

__all__ = ["Estimate", "Simulation", "simulate"]
