"""Lockstep reports: the ticks that readers have finished."""

from collections.abc import Sequence
from typing import Any

import iceoryx2 as iox

from regatta._contract import Done
from regatta._errors import PublishError, ReadError
from regatta._open import ClosedPort
from regatta._ports import Wake, create, update_connections


LEFT = 2**64 - 1
"""The tick that stands for all ticks from now on."""


class Reporter:
    """The sending end of lockstep reports: reports finished ticks under the reader's name."""

    def __init__(self, reports: Any, wake: Any, name: str) -> None:
        builder = reports.publisher_builder().max_loaned_samples(1)
        builder = builder.backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._reports = create(reports, reports.static_config.max_publishers, builder.create)
        self._wake = create(wake, wake.static_config.max_notifiers, lambda: wake.notifier_builder().create())
        self._name = name.encode()

    def done(self, run_id: int, tick: int) -> None:
        """Reports that a tick is finished, and wakes the processes that wait for it. Commands and columns must be sent before."""
        try:
            self._reports.send_copy(Done(run_id, tick, self._name))
            self._wake.notify()
        except (iox.LoanError, iox.SendError) as error:
            raise PublishError(f"can't publish a lockstep report ({error})") from None
        except iox.NotifierNotifyError:
            pass  # the processes that wait check by themselves a little later

    def leave(self, run_id: int) -> None:
        """Reports that this reader leaves the lockstep of a run, so that no process waits for it any more."""
        self.done(run_id, LEFT)

    def close(self) -> None:
        """Frees the places at the services."""
        self._reports = self._wake = ClosedPort("lockstep")

    def update(self) -> None:
        """Gives the last report to processes that have joined since. Must be called every now and then while no frame
        comes."""
        update_connections(self._reports)


class DoneReports:
    """The receiving end of lockstep reports: the last tick that each reader has finished."""

    def __init__(self, reports: Any, wake: Wake) -> None:
        builder = reports.subscriber_builder()
        self._reports = create(reports, reports.static_config.max_subscribers, builder.create)
        self._wake = wake
        self._finished: dict[str, tuple[int, int]] = {}

    def close(self) -> None:
        """Frees the places at the services."""
        self._reports = ClosedPort("lockstep")
        self._wake.close()

    def missing(self, names: Sequence[str], run_id: int, tick: int) -> list[str]:
        """Returns the readers among ``names`` that haven't finished a tick of a run yet."""
        try:
            while (sample := self._reports.receive()) is not None:
                done = Done.from_buffer_copy(sample.payload().contents)
                del sample  # given back before the next is asked for
                self._finished[done.name.decode(errors="replace")] = (done.run_id, done.tick)
        except iox.ReceiveError as error:
            raise ReadError(f"can't read lockstep reports ({error}); `regatta doctor` reports what is wrong") from None

        def has_finished(name: str) -> bool:
            finished = self._finished.get(name)
            return finished is not None and finished[0] == run_id and finished[1] >= tick

        return [name for name in names if not has_finished(name)]

    def sleep(self, seconds: float) -> None:
        """Sleeps until a reader reports, for ``seconds`` or about a tenth of a second at most."""
        self._wake.sleep(seconds)
