"""A small example of each mistake, and how it is mended, for `stlc check --explain CODE`.

The names `r1`, `r2` (agents), `base` (station), `dock`, `yard` (regions), `pillar` (obstacle) and
`radio` (channel) are taken as declared.
"""

from __future__ import annotations

from typing import Final

# code -> (wrong, right); codes that need files or options of the command line have none
EXAMPLES: Final[dict[str, tuple[str, str]]] = {
    "E0101": ("require a: eventually[0 5] r1 in dock", "require a: eventually[0, 5] r1 in dock"),
    "E0102": ("region g = box [0, 1] × [0, 1]", "region g = box [0, 1] x [0, 1]"),
    "E0103": ('import "lib.stl', 'import "lib.stl"'),
    "E0104": ("require a: eventually (r1 in dock", "require a: eventually (r1 in dock)"),
    "E0105": ("require a: eventually[0, 5] r1 in dock)", "require a: eventually[0, 5] r1 in dock"),
    "E0108": (
        "require a: always[0, 5] (r1 in dock implies once r1 in yard)",
        "require a: (not r1 in dock) until[0, 5] r1 in yard",
    ),
    "E0109": ("goal g = box [0, 1] x [0, 1]", "region g = box [0, 1] x [0, 1]"),
    "E0110": ("require a: eventually[0, 5]", "require a: eventually[0, 5] r1 in dock"),
    "E0111": ("require a: always[0, 5] r1.x <= 3 metres", "require a: always[0, 5] r1.x <= 3 m"),
    "E0115": ("require a: eventually[0, 5] r1.x = 3 m", "require a: eventually[0, 5] r1.x >= 3 m"),
    "E0201": ("require a: eventually[0, 5] r1 in dok", "require a: eventually[0, 5] r1 in dock"),
    "E0202": (
        "region g = box [0, 1] x [0, 1]\nobstacle g = box [3, 4] x [3, 4]",
        "region g = box [0, 1] x [0, 1]\nobstacle wall = box [3, 4] x [3, 4]",
    ),
    "E0203": ("require a: always[0, 5] r1 <= 3 m", "require a: always[0, 5] r1.x <= 3 m"),
    "E0204": (
        "require a: always[0, 5] distance(r1) <= 3 m",
        "require a: always[0, 5] distance(r1, base) <= 3 m",
    ),
    "E0205": ("param v = 2 * v", "param v = 2"),
    "E0206": ("require a: always[0, 5] r1.z <= 3 m", "require a: always[0, 5] r1.y <= 3 m"),
    "E0207": (
        "agent c : double_integrator { start (1, 1); max_speed 2 }",
        "agent c : double_integrator { start (1, 1); speed <= 2 }",
    ),
    "E0208": (
        "agent c : double_integrator { start (1, 1) mass 2 kg }",
        "agent c : double_integrator { start (1, 1); mass 2 kg }",
    ),
    "E0209": (
        "require a: always[0, 5] r1.x * r2.x <= 9",
        "require a: always[0, 5] (r1.x <= 3 m and r2.x <= 3 m)",
    ),
    "E0211": (
        "require a: not (always[0, 5] r1 outside pillar swept)",
        "require a: not (always[0, 5] r1 outside pillar)",
    ),
    "E0214": (
        "dynamics tank { A = [[1]]; B = [[1]] }\n"
        "agent t : tank { start 0; control |u| <= 1 }\n"
        "require a: eventually[0, 5] t in dock",
        "dynamics tank { A = [[1]]; B = [[1]]; states level }\n"
        "agent t : tank { start 0; control |u| <= 1 }\n"
        "require a: eventually[0, 5] t.level >= 2",
    ),
    "E0218": ("step 1 s\nstep 2 s", "step 2 s"),
    "E0219": (
        "param n = 0\nrequire a: always[0, 5] r1.x <= 3 / n",
        "param n = 1\nrequire a: always[0, 5] r1.x <= 3 / n",
    ),
    "E0221": (
        "require a: eventually[0, 5] exists k in 3..1: r1.x >= k",
        "require a: eventually[0, 5] exists k in 1..3: r1.x >= k",
    ),
    "E0301": (
        "signal v [furlong]",
        "signal v [m]",
    ),
    "E0302": (
        "require a: always[0, 5] rssi(r1, r2) + 3 dBm >= -60 dBm",
        "require a: always[0, 5] rssi(r1, r2) + 3 dB >= -60 dBm",
    ),
    "E0303": ("require a: always[0, 5] r1.x <= 3 dB", "require a: always[0, 5] r1.x <= 3 m"),
    "E0304": (
        "require a: always[0, 5] rssi(r1, r2) >= -70 dB",
        "require a: always[0, 5] rssi(r1, r2) >= -70 dBm",
    ),
    "E0305": (
        "require a: always[0, 5] 2 * rssi(r1, r2) >= -140 dBm",
        "require a: always[0, 5] rssi(r1, r2) >= -70 dBm",
    ),
    "E0306": ("step 2 m", "step 2 s"),
    "E0307": (
        "require a: always[0, 5] r1.x <= (4 m)^0.5",
        "require a: always[0, 5] r1.x <= 4^0.5 * 1 m",
    ),
    "E0308": (
        "dynamics k { A = [[800]]; B = [[1]]; continuous }\n"
        "agent t : k { start 0; control |u| <= 1 }\nrequire a: eventually[0, 5] t.x0 >= 1",
        "dynamics k { A = [[0.8]]; B = [[1]]; continuous }\n"
        "agent t : k { start 0; control |u| <= 1 }\nrequire a: eventually[0, 5] t.x0 >= 1",
    ),
    "E0309": (
        "channel c { path_loss L0 = -12 dBm, n = 3; d0 1e-300 m; partition 4 x 4 }",
        "channel c { path_loss L0 = -12 dBm, n = 3; d0 0.1 m; partition 4 x 4 }",
    ),
    "E0401": (
        "region g = polygon (0, 0) (2, 2) (2, 0) (0, 2)",
        "region g = polygon (0, 0) (2, 0) (2, 2) (0, 2)",
    ),
    "E0402": ("region g = box [3, 1] x [0, 1]", "region g = box [1, 3] x [0, 1]"),
    "E0403": (
        "workspace polygon (0, 0) (9, 0) (9, 9) (4, 4) (0, 9)",
        "workspace polygon (0, 0) (9, 0) (9, 9) (0, 9)",
    ),
    "E0404": ("region g = box [20, 21] x [0, 1]", "region g = box [8, 9] x [0, 1]"),
    "E0405": (
        "agent c : double_integrator { start (20, 1) }",
        "agent c : double_integrator { start (2, 1) }",
    ),
    "E0406": (
        "agent c : double_integrator { start (5, 5) }\nrequire a: always[0, 5] c outside pillar",
        "agent c : double_integrator { start (2, 5) }\nrequire a: always[0, 5] c outside pillar",
    ),
    "E0407": (
        "agent c : double_integrator { control |u| <= 1 }",
        "agent c : double_integrator { start (1, 1); control |u| <= 1 }",
    ),
    "E0408": (
        "dynamics d { A = [[1, 0]]; B = [[1]] }",
        "dynamics d { A = [[1]]; B = [[1]] }",
    ),
    "E0409": ("dynamics d { A = [[1]] }", "dynamics d { A = [[1]]; B = [[1]] }"),
    "E0410": (
        "agent c : double_integrator { start (1, 1); vx in [2, 1] }",
        "agent c : double_integrator { start (1, 1); vx in [-1, 2] }",
    ),
    "E0412": (
        "require a: always[0, 5] (rssi(r1, r2) >= -60 dBm) swept",
        "require a: always[0, 5] rssi(r1, r2) >= -60 dBm",
    ),
    "E0413": (
        "agent c : double_integrator { start (1, 1); control |u| <= 1; speed <= 1; "
        "turn_rate literal }",
        "agent c : double_integrator { start (1, 1); control |u| <= 1; speed <= 1; turn_rate on }",
    ),
    "E0414": (
        "agent c : double_integrator { start (1, 1); turn_rate on }",
        "agent c : double_integrator { start (1, 1); control |u| <= 1; speed <= 1; turn_rate on }",
    ),
    "E0416": (
        "region far = box [1e12, 2e12] x [0, 1]\nrequire a: eventually[0, 5] r1 in far",
        "region far = box [8, 9] x [0, 1]\nrequire a: eventually[0, 5] r1 in far",
    ),
    "E0417": (
        "dynamics drone = double_integrator { dimensions 3 }\n"
        "agent d : drone { start (1, 1, 5); control |u| <= 1 }\n"
        "require a: always[0, 5] rssi(d, base) >= -80 dBm",
        "dynamics drone = double_integrator { dimensions 3; pz in [0, 50] }\n"
        "agent d : drone { start (1, 1, 5); control |u| <= 1 }\n"
        "require a: always[0, 5] rssi(d, base) >= -80 dBm",
    ),
    "E0418": (
        "dynamics drone = double_integrator { dimensions 3; pz in [0, 50] }\n"
        "agent d : drone { start (1, 1, 5); control |u| <= 1 }\n"
        "require a: eventually[0, 5] distance(d, (3, 3)) <= 4",
        "dynamics drone = double_integrator { dimensions 3; pz in [0, 50] }\n"
        "agent d : drone { start (1, 1, 5); control |u| <= 1 }\n"
        "require a: eventually[0, 5] distance(d, (3, 3, 5)) <= 4",
    ),
    "E0419": (
        "agent c : unicycle { start (1, 1); speed <= 1 }",
        "agent c : unicycle { start (1, 1); speed <= 1; turn_rate <= 2 }",
    ),
    "E0420": (
        "agent c : unicycle { start (1, 1); speed <= 1; turn_rate <= 2; period 0.3 s }",
        "agent c : unicycle { start (1, 1); speed <= 1; turn_rate <= 2; period 0.25 s }",
    ),
    "E0501": (
        "step 0.5 s\nrequire a: eventually[0, 1.7 s] r1 in dock",
        "step 0.5 s\nrequire a: eventually[0, 2 s] r1 in dock",
    ),
    "E0502": ("require a: eventually[5, 0] r1 in dock", "require a: eventually[0, 5] r1 in dock"),
    "E0503": ("require a: eventually[-1, 5] r1 in dock", "require a: eventually[0, 5] r1 in dock"),
    "E0504": (
        "horizon 5\nrequire a: always[0, 3] eventually[0, 4] r1 in dock",
        "horizon 7\nrequire a: always[0, 3] eventually[0, 4] r1 in dock",
    ),
    "E0505": ("require a: always r1.y <= 5 m", "horizon 20\nrequire a: always r1.y <= 5 m"),
    "E0506": ("step 0 s", "step 0.5 s"),
    "E0507": (
        "require a: eventually[0, 5 m] r1 in dock",
        "require a: eventually[0, 5 s] r1 in dock",
    ),
    "E0508": (
        "require a: eventually[0, 100000000] r1 in dock",
        "require a: eventually[0, 100] r1 in dock",
    ),
    "E0601": (
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10 }\n"
        "require a: always[0, 5] snr(r1, r2, c) >= 3 dB",
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10; noise_floor -90 dBm }\n"
        "require a: always[0, 5] snr(r1, r2, c) >= 3 dB",
    ),
    "E0602": (
        "channel c { path_loss L0 = -40 dBm, n = 2; shadowing 10 dB^2; partition 10 x 10 }",
        "channel c { path_loss L0 = -40 dBm, n = 2; shadowing 10 dB^2; length 2 m; "
        "partition 10 x 10 }",
    ),
    "E0603": (
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10; noise_floor -90 dBm; "
        "fading 4 dB^2; modulation rayleigh_bpsk }",
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10; noise_floor -90 dBm; "
        "fading 4 dB^2; modulation bpsk }",
    ),
    "E0604": (
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10 }\n"
        "require a: always[0, 5] rssi(r1, r2) >= -60 dBm",
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 10 x 10 }\n"
        "require a: always[0, 5] rssi(r1, r2, c) >= -60 dBm",
    ),
    "E0605": (
        "require a: always[0, 5] P(rssi(r1, r2) >= -60 dBm) >= 1",
        "require a: always[0, 5] P(rssi(r1, r2) >= -60 dBm) >= 0.99",
    ),
    "E0606": (
        "require a: always[0, 5] rssi(r1, r2) >= rssi(r1, base)",
        "require a: always[0, 5] (rssi(r1, r2) >= -60 dBm and rssi(r1, base) <= -60 dBm)",
    ),
    "E0609": (
        "require a: always[0, 5] connected(agents, r1.x >= 3 m)",
        "require a: always[0, 5] connected(agents, radio, rssi >= -70 dBm)",
    ),
    "E0701": ("minimize r1.x", "minimize effort(r1)"),
    "E0702": (
        "require a: always[0, 5] (r1 in dock and rssi(r1, r2) >= -60 dBm)\nmaximize robustness",
        "require a: always[0, 5] (r1 in dock and rssi(r1, r2) >= -60 dBm)\n"
        "maximize robustness(scale(1 m, 10 dB))",
    ),
    "E0703": ("minimize -1 * effort", "minimize effort"),
    "E0704": ("horizon 5\nminimize effort[0, 9]", "horizon 9\nminimize effort[0, 9]"),
    "E0710": (
        "require net: always route(r1, base, link_cost <= 3)\nmaximize robustness(net)",
        "require net margin 0.5: always route(r1, base, link_cost <= 3)\nminimize effort",
    ),
    "E0705": (
        "require a: eventually[0, 5] r1.x >= 30 m",
        "require a: eventually[0, 5] r1.x >= 3 m",
    ),
    "E0706": (
        "prefer a late: always[0, 5] r1 in dock",
        "prefer a share: always[0, 5] r1 in dock",
    ),
    "E0806": (
        "require a: always[0, 20000] (r1.x >= 0 m until[0, 20000] r1.y >= 1 m)",
        "require a: always[0, 5] (r1.x >= 0 m until[0, 5] r1.y >= 1 m)",
    ),
    "E0807": (
        "channel wide { path_loss L0 = -12 dBm, n = 3; partition 100 x 100 }\n"
        "require a: always[0, 5] rssi(r1, r2, wide) >= -60 dBm",
        "channel wide { path_loss L0 = -12 dBm, n = 3; partition 10 x 10 }\n"
        "require a: always[0, 5] rssi(r1, r2, wide) >= -60 dBm",
    ),
    "W0101": (
        "require a: always[0, 5] r1.x >= 0 m and r1.y >= 0 m",
        "require a: always[0, 5] (r1.x >= 0 m and r1.y >= 0 m)",
    ),
    "W1001": (
        "obstacle wall = box [3, 4] x [3, 4]",
        "obstacle wall = box [3, 4] x [3, 4]\n"
        "require a: always[0, 5] forall r in agents: r outside wall",
    ),
    "W1002": ("param v = 2 m", "param v = 2 m\nrequire a: always[0, 5] r1.x <= v"),
    "W1003": ("region g = box [8, 12] x [0, 1]", "region g = box [8, 10] x [0, 1]"),
    "W1004": ("require a: always[0, 5] r1.x <= 30 m", "require a: always[0, 5] r1.x <= 3 m"),
    "W1005": ("require a: always[0, 5] r1.x != 3 m", "require a: always[0, 5] |r1.x - 3 m| >= 0.1"),
    "W1006": (
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 5 x 5; cost paper_inv_rssi }\n"
        "minimize link_cost(c, (r1, r2))",
        "channel c { path_loss L0 = -40 dBm, n = 2; partition 5 x 5; noise_floor -90 dBm }\n"
        "minimize link_cost(c, (r1, r2))",
    ),
    "W1008": (
        "agent c : double_integrator { start (1, 1); speed <= 2 polygon 8 outer }",
        "agent c : double_integrator { start (1, 1); speed <= 2 polygon 8 }",
    ),
    "W1010": (
        "require a: always[0, 5] r1 in dock",
        "require a: always[4, 5] r1 in dock",
    ),
    "W1012": (
        "obstacle a = box [3, 4] x [3, 4]\nobstacle b = box [4.0005, 5] x [3, 4]\n"
        "require a: always[0, 5] forall o in obstacles: r1 outside o",
        "obstacle a = box [3, 4] x [3, 4]\nobstacle b = box [4, 5] x [3, 4]\n"
        "require a: always[0, 5] forall o in obstacles: r1 outside o",
    ),
    "W1011": (
        "agent c : double_integrator { start (1, 1); control u <= 1 }",
        "agent c : double_integrator { start (1, 1); control |u| <= 1 }",
    ),
}
