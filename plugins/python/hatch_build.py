"""Puts the program ``regatta`` into the wheel if the environment variable ``REGATTA_WHEEL_PROGRAM`` names its file.

The wheel is for one platform then, whatever the version of Python. Without the variable it holds the package alone, for
all platforms.
"""

import os
import re
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "REGATTA_WHEEL_PROGRAM"

MACHINES = {0x3E: "x86_64", 0xB7: "aarch64"}
"""The names of processors in tags, by their number in the header of an ELF file."""


class ProgramHook(BuildHookInterface[Any]):
    """Called by hatchling for each wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Adds the program. pip installs it beside the interpreter."""
        if VARIABLE not in os.environ:
            return
        program = Path(os.environ[VARIABLE])
        build_data["shared_scripts"][str(program)] = program.name
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_of(program.read_bytes())}"


def platform_of(program: bytes) -> str:
    """Returns the platform of a program, as in the tag of a wheel.

    For Linux with glibc, this is the oldest glibc that has all symbols that the program uses: it doesn't start with an
    older one. Apart from glibc it needs nothing but ``libgcc_s``, which each such platform has.
    """
    versions = [int(version) for version in re.findall(rb"\0GLIBC_2\.(\d+)", program)]
    if program.startswith(b"\x7fELF") and versions:
        machine = MACHINES[int.from_bytes(program[18:20], "little")]
        return f"manylinux_2_{max(versions)}_{machine}"
    return re.sub("[-.]", "_", sysconfig.get_platform())
