"""Plans for teams, a few agents at a time against the others."""
