"""A frame: the poses of all robots at one tick."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from regatta._contract import BYTES_PER_LINE, WORDS_PER_LINE, FrameHeader
from regatta._errors import ReadError
from regatta._ports import Sample

if TYPE_CHECKING:
    from regatta._fleet import Fleet
    from regatta._world import World


@dataclass(frozen=True, eq=False)
class ColumnValues:
    """A reader's view of a column. ``values`` is a read-only view of shared memory."""

    run_id: int
    """The run that the values belong to."""
    tick: int
    """The tick that the values belong to: an older one than the frame's if the plugin that publishes them is slower."""
    values: npt.NDArray[np.float32]
    """One value per robot of that tick."""
    missed: int
    """The number of samples that were published between the one that this program got before and this one."""


class Frame:
    """A reader's view of a frame in shared memory.

    Its columns are numpy arrays that are read-only views of it: nothing is copied. Row ``i`` is the robot with the id
    ``i``; the values of rows whose ``state`` is :attr:`RobotState.ABSENT <regatta.RobotState.ABSENT>` are meaningless.

    A frame and its columns stay unchanged for as long as something refers to them. A reader can hold two frames, so
    that a loop can compare each with the one before; to keep values for longer, copy them: ``frame.x.copy()``.
    """

    __slots__ = ("_fleet", "_sample", "_words", "header")

    def __init__(self, sample: Sample[FrameHeader], fleet: Fleet) -> None:
        self.header = sample.header
        """The header, with all of the frame's metadata."""
        robots, stride = self.header.robots, self.header.stride_lines
        lines = 6 * stride + -(-stride // 4)
        if stride != -(-robots // WORDS_PER_LINE) or sample.elements < lines:
            raise ReadError(
                f"a frame of {sample.elements} lines contradicts its header ({robots} robots); its producer is at fault"
            )
        self._sample = sample
        self._words = sample.payload.view(np.float32)
        self._fleet = fleet

    def __len__(self) -> int:
        """Returns the number of rows: robot ids are ``0 .. len(frame) - 1``."""
        return self.header.robots

    def __repr__(self) -> str:
        return f"<regatta.Frame: tick {self.tick}, {len(self)} robots>"

    @property
    def run_id(self) -> int:
        """The id of the run, which differs between any two starts of a producer."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """Ticks since the start of the run."""
        return self.header.tick

    @property
    def missed(self) -> int:
        """The number of frames that were published between the one that this reader got before and this one, exactly. A
        loop with a rate skips frames on purpose; those count too."""
        return self._sample.missed

    @property
    def sim_time(self) -> float:
        """Simulated time since the start of the run, in seconds."""
        return self.header.sim_time_nanos * 1e-9

    @property
    def x(self) -> npt.NDArray[np.float32]:
        """Metres east."""
        return self._column(0)

    @property
    def y(self) -> npt.NDArray[np.float32]:
        """Metres north."""
        return self._column(1)

    @property
    def theta(self) -> npt.NDArray[np.float32]:
        """Heading in radians, in (-π, π], counter-clockwise from east."""
        return self._column(2)

    @property
    def speed(self) -> npt.NDArray[np.float32]:
        """Metres per second along the edge; negative in reverse gear."""
        return self._column(3)

    @property
    def s(self) -> npt.NDArray[np.float32]:
        """Metres along the edge from its origin node."""
        return self._column(4)

    @property
    def edge(self) -> npt.NDArray[np.uint32]:
        """Index into the world's edges, or :data:`NO_EDGE <regatta.NO_EDGE>`."""
        return self._column(5).view(np.uint32)

    @property
    def state(self) -> npt.NDArray[np.uint8]:
        """The state of each robot, a :class:`RobotState <regatta.RobotState>`."""
        start = 6 * self.header.stride_lines * BYTES_PER_LINE
        return self._sample.payload[start : start + self.header.robots]

    @property
    def world(self) -> World:
        """The route graph and the robot types that this frame belongs to.

        Raises :class:`ReadError <regatta.ReadError>` if the producer doesn't publish them.
        """
        return self._fleet._world_of(self.header)

    def column(self, name: str) -> ColumnValues | None:
        """Returns the newest values of a column, or ``None`` as long as no process has published any.

        Plugins publish columns (``collision``, for example), and so does the producer (``type``: each robot's index
        into the world's robot types). The first call opens the column, and waits a moment for the values that were
        published before. Compare the ``tick`` if the values must belong to this very frame. In lockstep they do if the
        loop comes after the plugin that publishes them: ``fleet.frames(after=["collision"])``.
        """
        return self._fleet._column_values(name)

    def _column(self, number: int) -> npt.NDArray[np.float32]:
        start = number * self.header.stride_lines * WORDS_PER_LINE
        return self._words[start : start + self.header.robots]
