"""A loop with a station to pick at and one to drop at, in SimPy: a second simulator.

The road is a ring of cells with room for one robot each. A robot drives from cell to cell at a
constant speed, and holds a cell until it has left it, so that robots queue behind a station and
never overtake. It stands at each of the two stations, half a loop apart, for a time that is
uniform between two values. Nothing of Regatta is used.

Prints the finished orders an hour of each seed, as a list in JSON.
"""

import argparse
import json
import random

import simpy


class Loop:
    """The ring, its stations and its finished orders."""

    def __init__(self, options: argparse.Namespace, seed: int) -> None:
        self.env = simpy.Environment()
        self.options = options
        self.random = random.Random(seed)
        count = round(options.length / options.cell)
        self.cells = [simpy.Resource(self.env) for _ in range(count)]
        self.pick, self.drop = 0, count // 2
        self.finished = 0

    def dwell(self) -> simpy.Timeout:
        """The time at a station."""
        return self.env.timeout(self.random.uniform(self.options.least, self.options.most))

    def robot(self, cell: int):
        """A robot that begins in a cell."""
        claim = self.cells[cell].request()
        yield claim
        while True:
            if cell in (self.pick, self.drop):
                yield self.dwell()
                self.finished += int(cell == self.drop and self.env.now > self.options.warm_up)
            following = (cell + 1) % len(self.cells)
            next_claim = self.cells[following].request()
            yield next_claim
            yield self.env.timeout(self.options.cell / self.options.speed)
            self.cells[cell].release(claim)
            cell, claim = following, next_claim

    def orders_per_hour(self) -> float:
        """Runs the loop, with its robots at equal distances in the beginning."""
        for index in range(self.options.robots):
            start = index * len(self.cells) // self.options.robots
            self.env.process(self.robot(start))
        self.env.run(until=self.options.warm_up + self.options.duration)
        return self.finished * 3600.0 / self.options.duration


def main() -> None:
    """Reads the options, and prints the answer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, required=True)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--length", type=float, default=40.0, help="of the loop, in metres")
    parser.add_argument("--cell", type=float, default=1.0, help="length of a cell, in metres")
    parser.add_argument("--speed", type=float, default=1.0, help="in metres per second")
    parser.add_argument("--least", type=float, default=2.0, help="seconds at a station")
    parser.add_argument("--most", type=float, default=18.0, help="seconds at a station")
    parser.add_argument("--warm-up", type=float, default=600.0, help="in seconds")
    parser.add_argument("--duration", type=float, default=5400.0, help="in seconds, after it")
    options = parser.parse_args()
    print(json.dumps([Loop(options, seed).orders_per_hour() for seed in range(options.seeds)]))


if __name__ == "__main__":
    main()
