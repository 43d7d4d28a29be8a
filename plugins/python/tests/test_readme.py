"""The programs in the READMEs work as they are printed there."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from conftest import PATIENCE, ROOT, Engine, binary, eventually

BLOCKS = [
    pytest.param(textwrap.dedent(block), id=f"{readme.parent.name}-{number}")
    for readme in (ROOT / "plugins/README.md", ROOT / "plugins/python/README.md")
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL))
]


RUNS = "regatta.run("
"""Such a program needs no fleet."""
STUDIES = "regatta.study("
READS = "regatta.read("
"""Such a program needs a recording."""

PROGRAMS = [block for block in BLOCKS if not any(word in str(block.values[0]) for word in (RUNS, STUDIES, READS))]
STUDIED = [block for block in BLOCKS if STUDIES in str(block.values[0])]
READINGS = [block for block in BLOCKS if READS in str(block.values[0])]
STEPS = [block for block in BLOCKS if "run.step(" in str(block.values[0])]
WHOLE_RUNS = [block for block in BLOCKS if RUNS in str(block.values[0]) and block not in STEPS]


@pytest.mark.parametrize("code", PROGRAMS)
def test_a_program_in_a_readme_runs(code: str, engine: Engine, tmp_path: Path) -> None:
    engine.start(scenario="warehouse-1000.yaml")
    (tmp_path / "plugin.py").write_text(code.replace('"default"', repr(engine.name)))
    program = engine.script(tmp_path / "plugin.py", *(["--fleet", engine.name] if "parse_args" in code else []))
    eventually("a line of output", lambda: program.output.count("\n") >= 1 or program.child.poll())
    program.end()
    assert program.output.startswith("tick ") and program.errors == ""


@pytest.mark.parametrize("code", WHOLE_RUNS)
def test_a_whole_run_in_a_readme_runs(code: str) -> None:
    environment = os.environ | {"REGATTA_PROGRAM": str(binary())}
    command = [sys.executable, "-c", code]
    ended = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    assert re.fullmatch(r"10 \S+ \S+ {}\n20 \S+ \S+ {}\n40 \S+ \S+ {}\n", ended.stdout), ended.stdout


@pytest.mark.parametrize("code", STEPS)
def test_a_run_in_steps_in_a_readme_runs(code: str) -> None:
    environment = os.environ | {"REGATTA_PROGRAM": str(binary())}
    command = [sys.executable, "-c", code]
    ended = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    lines = re.findall(r"^(\d+) s: \d+ robots busy, mean speed [\d.]+ m/s$", ended.stdout, re.MULTILINE)
    assert lines == ["60", "120", "180"], ended.stdout


@pytest.mark.parametrize("code", STUDIED)
def test_a_study_in_a_readme_runs(code: str) -> None:
    environment = os.environ | {"REGATTA_PROGRAM": str(binary())}
    command = [sys.executable, "-c", code]
    ended = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    assert len(re.findall(r"^speed factor \S+ \d [\d.]+ [\d.]+$", ended.stdout, re.MULTILINE)) == 6, ended.stdout


@pytest.mark.parametrize("code", READINGS)
def test_a_recording_in_a_readme_is_read(code: str, tmp_path: Path) -> None:
    scenario = tmp_path / "recorded.yaml"
    scenario.write_text(f"graph: {ROOT}/graphs/square.yaml\nrobots: [{{count: 3, routes: random}}]\nplugins: [record]\n")
    environment = os.environ | {"REGATTA_PROGRAM": str(binary())}
    command = [binary(), "run", scenario, "--in-process", "--simulated", "1s", "--rate", "10"]
    subprocess.run([str(part) for part in command], cwd=tmp_path, check=True, capture_output=True)
    recorded = next(tmp_path.glob("*.mcap"))
    recorded.rename(tmp_path / "run.mcap")
    ended = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    frames = 2 if "every=1.0" in code else 11
    assert len(re.findall(r"^tick \d+: 3 robots at [\d.]+ m/s$", ended.stdout, re.MULTILINE)) == frames, ended.stdout
