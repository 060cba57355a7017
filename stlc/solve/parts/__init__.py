"""Missions of several agents, bounded and started from what each agent would do alone."""
