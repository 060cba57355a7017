"""What the searches understand of a mission: agents as integrators, links, choices."""
