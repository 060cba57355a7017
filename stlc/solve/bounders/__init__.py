"""Lower bounds at the nodes of branch and bound: `Bounder`s of two agents and of teams."""
