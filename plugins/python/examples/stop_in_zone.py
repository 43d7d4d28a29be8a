"""Stops every robot that enters a zone, and prints where.

    regatta run graphs/thirty.yaml &
    python plugins/python/examples/stop_in_zone.py --zone 60 20 75 40
"""

import numpy as np

import regatta

parser = regatta.parser(__doc__)
corners = ("X0", "Y0", "X1", "Y1")
parser.add_argument("--zone", nargs=4, type=float, metavar=corners, required=True, help="two corners, in metres")
options = parser.parse_args()
(x0, x1), (y0, y1) = np.sort(options.zone[::2]), np.sort(options.zone[1::2])

fleet = regatta.join(options.fleet, options.name)
commands = fleet.commands()
for frame in fleet.frames(options.rate, options.after):
    inside = (frame.x >= x0) & (frame.x <= x1) & (frame.y >= y0) & (frame.y <= y1)
    for robot in np.flatnonzero(inside & (frame.state == regatta.RobotState.DRIVING)):
        commands.hold(robot)
        print(f"tick {frame.tick}: robot {robot} stops at ({frame.x[robot]:.2f}, {frame.y[robot]:.2f}) m", flush=True)
    commands.send()
