"""Continuous truth: random missions, and what their plans really do between the samples."""
