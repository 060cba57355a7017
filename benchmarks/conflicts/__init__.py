"""Missions with a planted conflict, and what an explanation of them has to hold."""
