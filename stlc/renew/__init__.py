"""Missions under way: what is left of one after some steps, planned anew from where it stands."""
