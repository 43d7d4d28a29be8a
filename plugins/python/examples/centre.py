"""Prints the centre of the fleet: the smallest plugin.

    regatta run graphs/thirty.yaml &
    python plugins/python/examples/centre.py --rate 1
"""

import regatta

options = regatta.parser(__doc__).parse_args()
for frame in regatta.join(options.fleet, options.name).frames(options.rate, options.after):
    print(f"tick {frame.tick}: centre ({frame.x.mean():.2f}, {frame.y.mean():.2f}) m", flush=True)
