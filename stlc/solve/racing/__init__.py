"""Several solvers, encodings and strategies against each other, here or on a cluster."""
