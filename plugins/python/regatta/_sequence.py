"""Sequence numbers: the one way in which readers count lost samples."""

from regatta._contract import Sequenced


class LostSamples:
    """Counts the samples of a service that a reader never got, exactly."""

    def __init__(self) -> None:
        self.total = 0
        """The number of samples lost so far, in all runs."""
        self._run_id = 0
        self._sequence = 0

    def before(self, header: Sequenced) -> int:
        """Registers a received sample, and returns the number of samples that were lost since the one before.

        Samples that were published before the reader joined are not lost. When the run changes, the samples of the new
        run before this one are; the number of missing last ones of the old run is unknown, and counts as none. A lower
        number than before within a run means that the publisher was replaced; nothing counts as lost then.
        """
        run_id, sequence = header.run_id, header.sequence
        if run_id == self._run_id:
            lost = max(0, sequence - self._sequence - 1)
        elif self._run_id == 0:
            lost = 0
        else:
            lost = max(0, sequence - 1)
        self._run_id, self._sequence = run_id, sequence
        self.total += lost
        return lost


class SequenceCounter:
    """Numbers the samples that a publisher sends in a run."""

    def __init__(self) -> None:
        self._run_id = 0
        self._sent = 0

    def next(self, run_id: int) -> int:
        """Returns the number of the next sample of a run, from 1."""
        self._sent = self._sent + 1 if run_id == self._run_id else 1
        self._run_id = run_id
        return self._sent
