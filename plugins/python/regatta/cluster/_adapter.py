"""Gives tasks from standard input to a cluster, and reports their ends on standard output."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from regatta.cluster._clusters import Cluster, ClusterError, lost
from regatta.cluster._run import Ended, content_hash

MOST_TRIES = 3
"""The number of times that a task is given to the cluster, if its worker is lost each time."""

START_SECS = 20.0
"""The longest time until the first worker is there."""

DESERTED_SECS = 300.0
"""The longest time without any worker."""

LOOK_SECS = 5.0
"""The time between two checks of a cluster that sends nothing."""


@dataclass
class Task:
    """A task: its id, and its files on this machine."""

    id: str
    job: Path
    layout: Path
    result: Path
    tries: int = 0


Event = str | tuple[Task, "Future[Ended]"] | None
"""A line of standard input, a task that has ended, or ``None``: this process is to end."""


def serve(cluster: Cluster, version: str) -> None:
    """Does tasks on a cluster until standard input ends. Raises :class:`ClusterError` if none can be done any more."""
    events: SimpleQueue[Event] = SimpleQueue()
    # Ctrl-C reaches the study, too, which then closes standard input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: events.put(None))
    threading.Thread(target=_read, args=(events,), daemon=True).start()
    try:
        if _wait_for_workers(cluster, events):
            Adapter(cluster, version, events).serve()
    finally:
        cluster.close()


def _read(events: SimpleQueue[Event]) -> None:
    for line in sys.stdin:
        events.put(line)
    events.put(None)


def _wait_for_workers(cluster: Cluster, events: SimpleQueue[Event]) -> bool:
    """Waits for the first worker, and writes the number of tasks that are done side
    by side. ``False`` if this process is to end."""
    start = time.monotonic()
    while (slots := cluster.slots()) == 0:
        if time.monotonic() - start > START_SECS:
            raise ClusterError(f"the {cluster.name} has no workers; start some, or leave --on out")
        try:
            # No task comes before the number of workers is known.
            events.get(timeout=0.2)
            return False
        except Empty:
            pass
    _say({"workers": slots})
    return True


def _say(line: dict[str, Any]) -> None:
    print(json.dumps(line), flush=True)


class Adapter:
    """Tasks under way on a cluster."""

    def __init__(self, cluster: Cluster, version: str, events: SimpleQueue[Event]) -> None:
        self._cluster, self._version, self._events = cluster, version, events
        self._seen = time.monotonic()
        self._left = 0

    def serve(self) -> None:
        """Does tasks until this process is to end."""
        while True:
            try:
                event = self._events.get(timeout=LOOK_SECS)
            except Empty:
                self._look()
                continue
            if event is None:
                return
            self.handle(event)

    def handle(self, event: str | tuple[Task, Future[Ended]]) -> None:
        """Takes a line of standard input, or a task that has ended."""
        if isinstance(event, str):
            self._begin(event)
        else:
            self._end(*event)

    def _begin(self, line: str) -> None:
        """Takes a task from a line."""
        fields = json.loads(line)
        self._left += 1
        self._seen = time.monotonic()
        self._submit(Task(fields["id"], Path(fields["job"]), Path(fields["layout"]), Path(fields["result"])))

    def _submit(self, task: Task) -> None:
        task.tries += 1
        try:
            future = self._cluster.submit((task.job.name, task.job.read_bytes()), task.layout, self._version)
        except OSError as error:
            self._report(task, f"can't read {error.filename}: {error.strerror}")
        else:
            future.add_done_callback(lambda done: self._events.put((task, done)))

    def _end(self, task: Task, future: Future[Ended]) -> None:
        """Reports a task that has ended, or begins it again."""
        self._seen = time.monotonic()
        try:
            ended = future.result()
        except ModuleNotFoundError as error:
            raise ClusterError(f"a worker has no Python module {error.name}: install the same wheel there") from None
        except Exception as error:
            ended = {"lost": f"{type(error).__name__}: {error}".partition("\n")[0]}
        if "unfit" in ended:
            raise ClusterError(ended["unfit"])
        if "failure" in ended:
            self._report(task, ended["failure"])
        elif "no_room" in ended:
            self._left -= 1
            _say({"id": task.id, "no_room": ended["no_room"]})
        elif "result" in ended and content_hash(ended["result"]) == ended["hash"]:
            _write(task.result, ended["result"])
            self._report(task, None)
        else:
            self._lose(task, ended.get("lost", "its result came back damaged"))

    def _lose(self, task: Task, reason: str) -> None:
        if self._cluster.is_lost():
            raise lost(self._cluster)
        if task.tries < MOST_TRIES:
            self._submit(task)
        else:
            self._report(task, f"lost {task.tries} times with its worker: {reason}")

    def _report(self, task: Task, failure: str | None) -> None:
        self._left -= 1
        _say({"id": task.id, "failure": failure})

    def _look(self) -> None:
        """Checks that there still are workers."""
        if self._left == 0 or self._cluster.slots() > 0:
            self._seen = time.monotonic()
        elif time.monotonic() - self._seen > DESERTED_SECS:
            raise ClusterError(
                f"the {self._cluster.name} has lost all workers; start some, and repeat the command to continue"
            )


def _write(path: Path, content: bytes) -> None:
    """Writes a file that appears under its name only when it is complete."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.unlink(missing_ok=True)
        with draft.open("xb") as file:
            file.write(content)
            file.flush()
            # Without it, a crash of the system could leave the new name with nothing in it.
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise ClusterError(f"{path}: can't write: {error.strerror}; repeat the command to continue") from None
