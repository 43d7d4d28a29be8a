"""Publishes each robot's speed, as a share of the fastest one's so far, as the column ``pace``: 0 stands, 1 is fastest.

A viewer can tint robots by any column, and any program can read it: ``frame.column("pace")``.

    regatta run graphs/thirty.yaml &
    python plugins/python/examples/tint_by_speed.py --rate 10
"""

import numpy as np

import regatta

options = regatta.parser(__doc__).parse_args()
fleet = regatta.join(options.fleet, options.name)
pace = fleet.column("pace")
fastest = 1e-3  # m/s, so that a fleet that stands has a pace too

for frame in fleet.frames(options.rate):
    speed = np.abs(frame.speed)
    speed[frame.state == regatta.RobotState.ABSENT] = 0.0
    fastest = max(fastest, speed.max(initial=0.0))
    pace.publish(frame, speed / fastest)
