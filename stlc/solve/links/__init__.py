"""Missions with link costs between moving agents: bounds, pruning and plans around the MILP.

The compiled model stays the only statement of the mission. A relaxation of it, agents as chains of
integrators on boxes of position and speed, is solved by dynamic programming; what it proves to be
too dear is fixed in the model, and the solver gets what is left.
"""
