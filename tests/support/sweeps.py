"""A mission with two parameters and two costs, to be swept over."""

MISSION = """step 1 s
horizon 3
workspace box [0, 6] x [0, 4]
param v = 2
param near = 1 m
agent a : single_integrator { start (1, 1); control |u| <= v }
station mast at (5, 3)
channel radio { path_loss L0 = -20 dBm, n = 2; fading 4 dB^2, shadowing 4 dB^2, length 2 m
  noise_floor -60 dBm; partition 6 x 4; bound centre; cost neg_rssi; pairs (a, mast) }
require go: eventually[0, 3] a.x >= 3 m + near
minimize effort
"""
