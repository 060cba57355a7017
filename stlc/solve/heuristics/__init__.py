"""Primal heuristics: plans to start from."""
