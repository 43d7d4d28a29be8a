"""The program ``regatta``."""

from __future__ import annotations

import os
import shutil
import sysconfig

PROGRAM_VARIABLE = "REGATTA_PROGRAM"
"""The environment variable with the program, instead of ``regatta``."""


def find_program() -> str | None:
    """Returns the path of the program; ``None`` if it isn't installed.

    The wheel's programs are beside the interpreter, which need not be on the ``PATH``.
    """
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)])
    return shutil.which(os.environ.get(PROGRAM_VARIABLE, "regatta"), path=path)
