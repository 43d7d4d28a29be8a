"""The program ``regatta``."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
from typing import IO

PROGRAM_VARIABLE = "REGATTA_PROGRAM"
"""The environment variable with the program, instead of ``regatta``."""

PARENT_VARIABLE = "REGATTA_PARENT"
"""The environment variable with the process that the program ends with, however that one ends."""

END_SECS = 10.0
"""The time, in seconds, within which a process ends that is asked to."""


def find_program() -> str | None:
    """Returns the path of the program; ``None`` if it isn't installed.

    The wheel's programs are beside the interpreter, which need not be on the ``PATH``.
    """
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)])
    return shutil.which(os.environ.get(PROGRAM_VARIABLE, "regatta"), path=path)


def environment() -> dict[str, str]:
    """Returns the environment of a program that ends with this process, also if a signal kills it (on Linux)."""
    return os.environ | {PARENT_VARIABLE: str(os.getpid())}


def end(process: subprocess.Popen[bytes], errors: IO[bytes]) -> None:
    """Ends a process of the program, and closes the file of its errors. A finaliser calls it: when the object that
    started the process is closed, when nothing refers to it any more, or when the interpreter ends."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(END_SECS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    errors.close()
