"""A mission over its parameters, and two of its costs against each other."""

from stlc.sweep.ask import Answer, Question
from stlc.sweep.axes import Axis, points
from stlc.sweep.frontier import Frontier, frontier

__all__ = ["Answer", "Axis", "Frontier", "Question", "frontier", "points"]
