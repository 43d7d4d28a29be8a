"""``python3 -m regatta.cluster ADDRESS``."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from typing import TYPE_CHECKING

from regatta.cluster._adapter import serve
from regatta.cluster._clusters import ClusterError, connect

if TYPE_CHECKING:
    from regatta.cluster._run import Ended


def call(function: str, *arguments: object) -> Ended:
    """Calls a function of ``_run`` on a worker. It is sent there as code, as it is in ``__main__``: so a scheduler, which
    loads it too, doesn't need this package."""
    from importlib import import_module

    ended: Ended = getattr(import_module("regatta.cluster._run"), function)(*arguments)
    return ended


def main(address: str) -> int:
    """Does the tasks on standard input, and returns the exit code."""
    # Standard error is read at the end only, and the user sees its last line.
    logging.disable()
    warnings.simplefilter("ignore")
    try:
        serve(connect(address, call), os.environ.get("REGATTA_STUDY_VERSION", ""))
    except ClusterError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python3 -m regatta.cluster ADDRESS (regatta study --on ADDRESS starts it)")
    code = main(sys.argv[1])
    sys.stdout.flush()
    sys.stderr.flush()
    # At once: threads of the cluster's library may still wait for tasks that were cancelled.
    os._exit(code)
