"""What holds of every run of a mission: ranges, reach sets, bounds, goals, stages, conflicts."""
