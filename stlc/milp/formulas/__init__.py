"""Formulas as columns and rows of a Model."""
