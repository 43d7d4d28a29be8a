"""Runs: whole ones that no process watches, and those that a program steps through."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from typing import overload

from regatta._live import Run as Run
from regatta._live import RunError as RunError
from regatta._program import find_program


@dataclass(frozen=True)
class RunResult:
    """The figures of a run."""

    robots: int
    """The number of robots at the end."""
    ticks: int
    """The number of ticks."""
    sim_time_secs: float
    """Simulated time, in seconds."""
    wall_time_secs: float
    """The time that the run took, in seconds."""
    orders_finished: int
    """Transport orders that were carried out."""
    orders_open: int
    """Transport orders that weren't over at the end."""
    orders_failed: int
    """Transport orders that the fleet manager gave up."""
    orders_per_hour: float
    """Finished transport orders per simulated hour."""
    service_p50_secs: float | None
    """The shortest time from an order's creation to its end that half of the orders don't exceed,
    in seconds; ``None`` if none was finished."""
    service_p99_secs: float | None
    """The 99th percentile of it."""
    utilisation: float
    """The part of the robots' time with an order, from 0 to 1."""
    waiting: float
    """The part of the robots' time in which they stood and waited for room, from 0 to 1."""
    findings: dict[str, int]
    """The validator's findings by kind. An empty one means that robots never touched, and nothing else was found."""
    digest: str
    """A hash of all frames: the same on every machine."""


@overload
def run(
    scenario: str | os.PathLike[str],
    simulated: float,
    *,
    robots: int | None = None,
    seed: int | None = None,
    trust: bool = False,
) -> RunResult: ...
@overload
def run(
    scenario: str | os.PathLike[str],
    simulated: None = None,
    *,
    robots: int | None = None,
    seed: int | None = None,
    trust: bool = False,
) -> Run: ...
def run(
    scenario: str | os.PathLike[str],
    simulated: float | None = None,
    *,
    robots: int | None = None,
    seed: int | None = None,
    trust: bool = False,
) -> RunResult | Run:
    """Runs a scenario or a layout: for ``simulated`` seconds, as fast as possible, or step by step.

    With ``simulated`` it returns the figures of the run. Engine, fleet manager and validator run in one process, which
    no other process sees. Without, it returns a :class:`Run <regatta.Run>`, which other processes may watch::

        with regatta.run("graphs/warehouse-charging.yaml", robots=20) as run:
            frame = run.step(60)
            run.fleet.send(3, "Dock 1")
            print(frame.to_pandas().groupby("activity", observed=True).speed_m_per_s.mean(), run.work)

    ``robots`` and ``seed`` replace those of the scenario. ``trust`` allows its plugins the files and addresses that it
    names.

    >>> regatta.run("graphs/warehouse-charging.yaml", 3600, robots=20).orders_per_hour  # doctest: +SKIP
    """
    if simulated is None:
        return Run(scenario, robots=robots, seed=seed, trust=trust)
    program = find_program()
    if program is None:
        raise RunError("the program regatta isn't installed: install the wheel, or set REGATTA_PROGRAM to its path")
    command = [program, "run", os.fspath(scenario), "--in-process", "--json", "--simulated", f"{simulated}s"]
    command += [] if robots is None else ["--robots", str(robots)]
    command += [] if seed is None else ["--seed", str(seed)]
    command += ["--trust"] if trust else []
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    # Plugins of the scenario may have printed summaries before.
    lines = ended.stdout.splitlines()
    if not lines or not lines[-1].startswith("{"):
        errors = [line for line in ended.stderr.splitlines() if line.strip()]
        raise RunError(errors[-1].removeprefix("regatta: ") if errors else "the run ended without a result")
    return RunResult(**json.loads(lines[-1]))
