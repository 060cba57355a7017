"""The radio channel: from measurements to a model, its bounds, and tables for the MILP."""
