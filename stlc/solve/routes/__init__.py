"""One agent's way through a whole mission: runs that keep track of what is still to be done."""
