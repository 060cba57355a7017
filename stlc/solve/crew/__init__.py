"""Who makes the small solves of a search: this process, some of its own, or a cluster."""
