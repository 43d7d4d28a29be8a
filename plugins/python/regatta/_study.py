"""Studies: how many robots a plant holds."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from regatta._errors import Error
from regatta._program import find_program

if TYPE_CHECKING:
    import pandas
    import polars

INTERVALS = (
    "orders_per_hour",
    "stops_per_hour",
    "service_mean_secs",
    "service_p50_secs",
    "service_p90_secs",
    "service_p95_secs",
    "service_p99_secs",
    "service_longest_secs",
    "late",
    "utilisation",
    "waiting",
    "empty",
    "open_orders",
)
"""The figures of a point that are means over its runs. A row has each with half of its 95 % interval, ``…_half_width``."""


class StudyError(Error):
    """A study has failed."""


@dataclass(frozen=True)
class Study:
    """The result of a study."""

    answers: tuple[str, ...]
    """The answer for each variant, in words, and what restricts it."""
    rows: tuple[dict[str, Any], ...]
    """A row for each variant and number of robots: the mean figures over its runs, its standing against each target (``met``,
    ``open`` or ``missed``), the numbers of runs, of runs that stalled, and of contacts."""
    json: dict[str, Any]
    """Everything, as ``study.json`` has it."""

    @property
    def least(self) -> dict[str, int | None]:
        """The least number of robots of each variant that meets the targets, by the variant's name; ``None`` if none of the
        numbers that were tried does."""
        found = {variant["name"]: variant["least"] for variant in self.json["variants"]}
        return {name: least and least["robots"] for name, least in found.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the rows as a data frame of pandas, which must be installed."""
        import pandas

        return pandas.DataFrame(list(self.rows))

    def to_polars(self) -> polars.DataFrame:
        """Returns the rows as a data frame of polars, which must be installed."""
        import polars

        return polars.DataFrame(list(self.rows))


def study(
    plant: str | os.PathLike[str],
    robots: str | int | Iterable[int] | None = None,
    *,
    minutes: float | None = None,
    seeds: tuple[int, int] | None = None,
    vary: Mapping[str, Sequence[Any]] | None = None,
    orders: str | os.PathLike[str] | None = None,
    targets: Sequence[str] = (),
    output: str | os.PathLike[str] | None = None,
    arguments: Sequence[str] = (),
) -> Study:
    """Computes how many robots a plant holds, by many runs, as ``regatta study`` does.

    ``plant`` is a layout of any format, a scenario or a study file. ``robots`` are numbers to try, or a range such as
    ``"1..64"``; ``minutes`` is the simulated time of a run, ``seeds`` the least and the largest number of runs of a
    point. ``vary`` has settings with the values to compare. ``orders`` is a file with the orders of a day, in place of the
    load. With ``targets`` such as ``"p99 service < 6min"`` the answer is the least number of robots that meets all of them
    (:attr:`Study.least`). The page of results and all files stay in the folder
    ``output``; without one they are deleted. ``arguments`` are further arguments of the command.

    >>> table = regatta.study("plant.lif.json", [1, 2, 4, 8], vary={"max_speed": [1.0, 1.5]}).to_pandas()  # doctest: +SKIP
    """
    program = find_program()
    if program is None:
        raise StudyError("the program regatta isn't installed: install the wheel, or set REGATTA_PROGRAM to its path")
    with tempfile.TemporaryDirectory(prefix="regatta-study-") as temporary:
        folder = Path(temporary) / "study" if output is None else Path(output)
        command = [program, "study", os.fspath(plant), "--output", str(folder)]
        command += [] if robots is None else ["--robots", _robots(robots)]
        command += [] if minutes is None else ["--duration", f"{minutes * 60}s"]
        command += [] if seeds is None else ["--seeds", f"{seeds[0]}..{seeds[1]}"]
        command += [] if orders is None else ["--orders", os.fspath(orders)]
        for target in targets:
            command += ["--target", target]
        for setting, values in (vary or {}).items():
            command += ["--vary", f"{setting}={','.join(json.dumps(value) for value in values)}"]
        ended = subprocess.run(
            [*command, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
        )
        return _result(folder / "study.json", ended)


def _robots(robots: str | int | Iterable[int]) -> str:
    if isinstance(robots, (str, int)):
        return str(robots)
    return ",".join(str(number) for number in robots)


def _result(file: Path, ended: subprocess.CompletedProcess[str]) -> Study:
    # A study with contacts, or without an answer, ends with exit code 1 and has a result all the same.
    if ended.returncode not in (0, 1) or not file.is_file():
        errors = [line for line in ended.stderr.splitlines() if line.strip()]
        raise StudyError(errors[-1].removeprefix("regatta: ") if errors else "the study ended without a result")
    answers = [line for line in ended.stdout.splitlines() if line.strip() and not line.endswith("index.html")]
    result: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    rows = [_row(variant, point) for variant in result["variants"] for point in variant["points"]]
    return Study(tuple(answers), tuple(rows), result)


def _row(variant: dict[str, Any], point: dict[str, Any]) -> dict[str, Any]:
    row: dict[str, Any] = {"variant": variant["name"], "robots": point["robots"]}
    for name in INTERVALS:
        interval = point[name] or {"mean": None, "half_width": None}
        row |= {name: interval["mean"], f"{name}_half_width": interval["half_width"]}
    stalled = sum(bool(run["stalls"]) for run in point["runs"])
    row |= {target["target"]: target["standing"] for target in point["targets"]}
    return row | {"runs": len(point["runs"]), "stalled_runs": stalled, "contacts": point["contacts"]}
