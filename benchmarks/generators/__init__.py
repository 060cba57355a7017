"""Seeded generators of benchmark missions: parameters in, the text of a `.stl` file out."""
