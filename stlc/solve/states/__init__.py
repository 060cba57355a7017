"""States of one agent at each step as boxes of position and rate, and the steps between them."""
