"""Publishes the column ``relative_speed``: each robot's speed relative to the fastest speed so far, from 0 to 1.

A viewer can tint robots by any column, and any program can read it: ``frame.column("relative_speed")``.

    regatta run graphs/thirty.yaml &
    python plugins/python/examples/tint_by_speed.py --rate 10
"""

import numpy as np

import regatta

options = regatta.parser(__doc__).parse_args()
fleet = regatta.join(options.fleet, options.name)
column = fleet.column("relative_speed")
fastest = 1e-3  # m/s, so that a fleet that stands still divides by a positive number

for frame in fleet.frames(options.rate, options.after):
    speed = np.abs(frame.speed)
    speed[frame.state == regatta.RobotState.ABSENT] = 0.0
    fastest = max(fastest, speed.max(initial=0.0))
    column.publish(frame, speed / fastest)
