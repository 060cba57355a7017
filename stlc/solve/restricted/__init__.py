"""The compiled model with bounds drawn in, and what one search holds: clock, incumbent."""
