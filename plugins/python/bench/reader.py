"""Measures the cost of reading: frames per second, processor time, and the age of a frame when it is read.

    regatta engine graphs/warehouse-1000.yaml --robots 10000 --fleet bench &
    python plugins/python/bench/reader.py --fleet bench

With an engine at ``--speed max`` it shows how many frames per second this program can read at most.
"""

import resource
import time

import numpy as np

import regatta

parser = regatta.parser(__doc__)
parser.add_argument("--seconds", type=float, default=10.0, help="how long to measure [default: %(default)s]")
options = parser.parse_args()


def processor_seconds() -> float:
    """Returns the processor time of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


ages: list[float] = []
ticks: list[int] = []
mean = 0.0
begin = used = time.monotonic()
for frame in regatta.join(options.fleet, options.name).frames(options.rate, options.after):
    age = time.time_ns() - frame.header.wall_time_nanos
    mean = float(frame.x.mean())
    if not ticks:
        # The first frame may have been published long ago.
        begin, used = time.monotonic(), processor_seconds()
    else:
        ages.append(age * 1e-3)
    ticks.append(frame.tick)
    if time.monotonic() - begin >= options.seconds:
        break

took, cpu, frames = time.monotonic() - begin, processor_seconds() - used, len(ages)
published = ticks[-1] - ticks[0]
p50, p99 = np.percentile(ages, [50, 99])
print(
    f"{len(frame):,} robots: {frames / took:.0f} of {published / took:.0f} frames a second;"
    f" {100 * cpu / took:.1f} % of a core, {1e6 * cpu / frames:.0f} µs a frame;"
    f" age when read: median {p50:.0f} µs, 99 % {p99:.0f} µs; mean of x {mean:.2f} m"
)
