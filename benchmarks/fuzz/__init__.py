"""Damaged missions and what the commands make of them."""
