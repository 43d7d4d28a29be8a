"""The place of this user's shared memory: the directory and prefix that Regatta's other programs use."""

import os
import stat
from functools import cache
from pathlib import Path
from typing import Any

import iceoryx2 as iox

from regatta._errors import OpenError

RUNTIME_DIR_VARIABLE = "REGATTA_RUNTIME_DIR"
"""The environment variable with the directory of iceoryx2's files. Without it, it is ``/tmp/regatta-UID``, which only this
user can use."""


@cache
def iceoryx2_config() -> Any:
    """Returns the configuration of iceoryx2. The names of segments begin with the identity of the directory (device and
    inode): processes that don't see the same directory never see the same segments."""
    config = iox.config.default()
    if not hasattr(os, "getuid"):
        return config
    directory = _directory()
    status = directory.stat()
    config.global_cfg.root_path = iox.Path.new(str(directory))
    config.global_cfg.prefix = iox.FileName.new(f"regatta_{status.st_dev:x}-{status.st_ino:x}_")
    return config


def _directory() -> Path:
    given = os.environ.get(RUNTIME_DIR_VARIABLE)
    directory = Path(given) if given else Path(f"/tmp/regatta-{os.getuid()}")
    try:
        if given:
            directory.mkdir(parents=True, exist_ok=True)
            directory = directory.resolve()
        else:
            directory.mkdir(mode=0o700, exist_ok=True)
        status = directory.lstat()
    except OSError as error:
        raise _unusable(directory, error.strerror) from None
    # Another user may have created it.
    if not stat.S_ISDIR(status.st_mode):
        raise _unusable(directory, "it is not a directory")
    if status.st_uid != os.getuid():
        raise _unusable(directory, f"it belongs to user {status.st_uid}")
    if not given and status.st_mode & 0o022:
        raise _unusable(directory, "other users may write to it")
    return directory


def _unusable(directory: Path, reason: str | None) -> OpenError:
    return OpenError(
        f"can't keep the files of shared memory in {directory} ({reason});"
        f" set {RUNTIME_DIR_VARIABLE} to a directory of your own"
    )
