"""The place of this user's shared memory: the directory and prefix that Regatta's other programs use."""

import os
import stat
import time
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
    _check_neighbours(directory)
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


def _check_neighbours(directory: Path) -> None:
    """Checks that the processes that use the directory see this process's ``/dev/shm``, and counts this process as one of
    them: each holds a lock on a file with its identity as long as it lives. Otherwise it would take their fleets for dead
    ones, and clean up after them."""
    import fcntl

    try:
        status = os.stat("/dev/shm")
    except OSError:
        return
    own = f"{status.st_dev:x}-{status.st_ino:x}".encode()
    try:
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        file = os.open(directory / "shared_memory", flags, 0o600)
    except OSError as error:
        raise _unusable(directory, error.strerror) from None
    for _ in range(20):
        fcntl.flock(file, fcntl.LOCK_SH)
        if os.pread(file, 64, 0) == own:
            return  # Open, and locked, until the process ends.
        fcntl.flock(file, fcntl.LOCK_UN)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.ftruncate(file, 0)
            os.pwrite(file, own, 0)
        except BlockingIOError:
            time.sleep(0.005)
        fcntl.flock(file, fcntl.LOCK_UN)
    os.close(file)
    raise _unusable(
        directory,
        "processes that see another /dev/shm use it: share /dev/shm too, by `docker run --ipc=host` or a volume",
    )


def _unusable(directory: Path, reason: str | None) -> OpenError:
    return OpenError(
        f"can't keep the files of shared memory in {directory} ({reason});"
        f" set {RUNTIME_DIR_VARIABLE} to a directory of your own"
    )
