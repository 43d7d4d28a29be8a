"""Clusters that take tasks: Dask and Ray."""

from __future__ import annotations

import contextlib
import hashlib
import socket
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit

from regatta.cluster._run import Ended, Job

REACH_SECS = 3.0
"""The longest time until a connection is accepted."""

DASK_SECS = 8.0
"""The longest time from then on until a Dask scheduler answers."""

RAY_SECS = 90.0
"""The same for Ray, which starts a process for each client."""

CLOSE_SECS = 2
"""The longest time to disconnect from a cluster."""

Call = Callable[..., Ended]
"""Calls a function of ``_run`` by its name, on a worker."""


class ClusterError(Exception):
    """No task can be done. The message is one line, and says what to do."""


class NoAnswerError(Exception):
    """The server at an address isn't a cluster."""


class Cluster(Protocol):
    """A cluster that takes tasks."""

    name: str

    def slots(self) -> int:
        """Returns the number of tasks that are done side by side."""

    def is_lost(self) -> bool:
        """Whether the connection to the cluster has ended."""

    def submit(self, job: Job, layout: Path, version: str) -> Future[Ended]:
        """Gives a task to the cluster: the name and the content of its file, and the file of its layout."""

    def close(self) -> None:
        """Stops the tasks that are under way."""


class Dask:
    """The workers of a Dask scheduler. Each of their threads is a slot."""

    def __init__(self, address: str, call: Call) -> None:
        self.name = f"Dask scheduler at {address}"
        try:
            import distributed
        except ImportError:
            raise ClusterError(f"{sys.executable} has no Dask: pip install 'regatta-sim[study]'") from None
        try:
            # Its types are incomplete.
            connect_to: Any = distributed.Client
            self._client = connect_to(address, timeout=DASK_SECS, set_as_default=False)
        except Exception:
            raise NoAnswerError from None
        self._call = call
        self._executor = self._client.get_executor(pure=False)
        self._layouts: dict[str, Any] = {}

    def slots(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        # Of the connection: each release has other ones.
        except Exception:
            raise lost(self) from None

    def is_lost(self) -> bool:
        return bool(self._client.status != "running")

    def submit(self, job: Job, layout: Path, version: str) -> Future[Ended]:
        future: Future[Ended] = self._executor.submit(
            self._call, "run_in_dask", job, self._layout(layout), layout.name, version
        )
        return future

    def _layout(self, path: Path) -> Any:
        """Returns a layout as a task, whose result is its content: unlike data that is scattered, it isn't lost with the
        workers that have it. It is sent once."""
        if path.name not in self._layouts:
            content = path.read_bytes()
            key = f"regatta-layout-{hashlib.sha256(content).hexdigest()}"
            self._layouts[path.name] = self._client.submit(bytes, content, key=key)
        return self._layouts[path.name]

    def close(self) -> None:
        # A scheduler that doesn't answer any more notices the end of this client by itself.
        with contextlib.suppress(Exception):
            self._executor.shutdown(wait=False)
            self._client.close(timeout=CLOSE_SECS)


class Ray:
    """A cluster of Ray, reached by its client server. Each processor is a slot."""

    def __init__(self, address: str, call: Call) -> None:
        self.name = f"Ray cluster at {address}"
        try:
            import ray
            # Ray's client needs it, and Ray alone doesn't bring it.
            import grpc  # noqa: F401
        except ImportError as error:
            lacks = "no Ray" if error.name == "ray" else "Ray without its client"
            raise ClusterError(f"{sys.executable} has {lacks}: pip install 'regatta-sim[study-ray]'") from None
        self._ray: Any = ray
        try:
            ray.init(address=address, log_to_driver=False)
        except Exception:
            raise NoAnswerError from None
        self._run: Any = self._ray.remote(num_cpus=1, max_retries=2)(call)
        self._layouts: dict[str, Any] = {}
        self._under_way: dict[Future[Ended], Any] = {}

    def slots(self) -> int:
        try:
            return int(self._ray.cluster_resources().get("CPU", 0))
        except Exception:
            raise lost(self) from None

    def is_lost(self) -> bool:
        return not self._ray.is_initialized()

    def submit(self, job: Job, layout: Path, version: str) -> Future[Ended]:
        if layout.name not in self._layouts:
            self._layouts[layout.name] = self._ray.put(layout.read_bytes())
        reference = self._run.remote("run_in_ray", job, self._layouts[layout.name], layout.name, version)
        future: Future[Ended] = reference.future()
        self._under_way[future] = reference
        future.add_done_callback(lambda done: self._under_way.pop(done, None) and None)
        return future

    def close(self) -> None:
        with contextlib.suppress(Exception):
            for reference in list(self._under_way.values()):
                self._ray.cancel(reference)
            self._ray.shutdown()


def lost(cluster: Cluster) -> ClusterError:
    """Returns the error of a connection that has ended."""
    return ClusterError(f"the connection to the {cluster.name} is lost; repeat the command to continue")


def connect(address: str, call: Call) -> Cluster:
    """Reaches the cluster at an address, or raises :class:`ClusterError`."""
    is_ray = address.startswith("ray://")
    what, secs = ("Ray cluster", RAY_SECS) if is_ray else ("Dask scheduler", DASK_SECS)
    try:
        parts = urlsplit(address)
        # Both libraries would retry for ever if nothing listens at the address.
        socket.create_connection((parts.hostname or "", parts.port or 0), REACH_SECS).close()
        return _within(secs, lambda: Ray(address, call) if is_ray else Dask(address, call))
    except (OSError, ValueError, FutureTimeoutError, NoAnswerError):
        raise ClusterError(f"no {what} answers at {address}; start one, or leave --on out") from None


def _within(secs: float, make: Callable[[], Cluster]) -> Cluster:
    """Makes a connection, or gives up after a time: the libraries wait for ever for a program that listens but sends
    nothing."""
    made: Future[Cluster] = Future()

    def work() -> None:
        try:
            made.set_result(make())
        except BaseException as error:
            made.set_exception(error)

    threading.Thread(target=work, daemon=True).start()
    return made.result(secs)
