"""A run of a study on a worker: writes its files, runs the wheel's program, and reads the result."""

from __future__ import annotations

import hashlib
import socket
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypedDict

from regatta._program import environment, find_program

UNWRITABLE = 74
"""The exit code of a run whose result can't be written."""

NO_ROOM = 65
"""The exit code of a run whose robots don't fit on the layout."""

CHECK_SECS = 0.5
"""The time between two checks whether a run is still wanted."""

END_SECS = 10.0
"""The longest time that a run may take to end when it is asked to."""


Job = tuple[str, bytes]
"""The name and the content of a job's file. The name is the hash of the content."""


class Ended(TypedDict, total=False):
    """The end of a run: a result and its hash, or the reason why there is none."""

    result: bytes
    hash: str
    failure: str
    """The run fails wherever it runs."""
    no_room: str
    """The layout has no room for so many robots."""
    lost: str
    """It was ended from outside, and may succeed elsewhere."""
    unfit: str
    """No run can succeed on this worker."""


class Exit(NamedTuple):
    """The exit code of a program, and the last line on its standard error."""

    code: int
    line: str


def content_hash(content: bytes) -> str:
    """Returns the hash by which a result is checked when it has come back."""
    return hashlib.sha256(content).hexdigest()


def run_in_dask(job: Job, layout: bytes, layout_name: str, version: str) -> Ended:
    """Does a run on a worker of Dask."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def is_wanted() -> bool:
        # Dask can't stop a thread. It only notes that the task was cancelled, or that the scheduler is gone.
        task = worker.state.tasks.get(key)
        return task is not None and task.state == "executing" and worker.status.name not in ("closing", "closed", "failed")

    # The next worker removes the files of a killed worker.
    return run(job, layout, layout_name, version, worker.local_directory, is_wanted)


def run_in_ray(job: Job, layout: bytes, layout_name: str, version: str) -> Ended:
    """Does a run on a worker of Ray, which stops it by an exception."""
    return run(job, layout, layout_name, version, None, lambda: True)


def run(
    job: Job, layout: bytes, layout_name: str, version: str, parent: str | None, is_wanted: Callable[[], bool]
) -> Ended:
    """Does a run with the program of a version, in a temporary folder."""
    program = find_program()
    if program is None:
        return {"unfit": f"worker {_host()} has no program regatta: install the same wheel there"}
    if (found := _version(program)) != version:
        return {"unfit": f"worker {_host()} has Regatta {found}, and this is {version}: install the same wheel there"}
    try:
        with tempfile.TemporaryDirectory(prefix="regatta-study-", dir=parent) as folder:
            return _run_in(Path(folder), program, job, layout, layout_name, is_wanted)
    except OSError as error:
        return {"unfit": f"worker {_host()}: {error}"}


def _host() -> str:
    return socket.gethostname()


def _version(program: str) -> str:
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
    return said.partition("\n")[0].removeprefix("regatta ")


def _run_in(
    folder: Path, program: str, job: Job, layout: bytes, layout_name: str, is_wanted: Callable[[], bool]
) -> Ended:
    name, content = job
    job_file, layout_file, result_file = folder / name, folder / layout_name, folder / "result.json"
    job_file.write_bytes(content)
    layout_file.write_bytes(layout)
    arguments = [program, "study-run", job_file, "--layout", layout_file, "--output", result_file, "--trust"]
    exited = _exit([str(argument) for argument in arguments], is_wanted)
    if exited is None:
        return {"lost": "it was cancelled"}
    if exited.code == 0:
        result = result_file.read_bytes()
        return {"result": result, "hash": content_hash(result)}
    if exited.code == UNWRITABLE:
        return {"unfit": f"worker {_host()}: {exited.line}"}
    if exited.code == NO_ROOM:
        return {"no_room": exited.line}
    # Slurm asks all processes of a job to end, this one and the worker alike.
    if exited.code < 0 or exited.line == "interrupted":
        return {"lost": f"it was ended on {_host()}"}
    return {"failure": exited.line or "it ended without a word"}


def _exit(command: list[str], is_wanted: Callable[[], bool]) -> Exit | None:
    """Runs a program to its end. Returns ``None`` if it isn't wanted any more."""
    child = subprocess.Popen(
        command, env=environment(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    try:
        while is_wanted():
            try:
                errors = child.communicate(timeout=CHECK_SECS)[1].decode(errors="replace")
            except subprocess.TimeoutExpired:
                continue
            lines = [line for line in errors.splitlines() if line.strip()]
            return Exit(child.returncode, lines[-1].removeprefix("regatta: ") if lines else "")
        return None
    finally:
        _end(child)


def _end(child: subprocess.Popen[bytes]) -> None:
    """Asks a program to end, so that it removes its shared memory."""
    if child.poll() is None:
        child.terminate()
        try:
            child.wait(END_SECS)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
