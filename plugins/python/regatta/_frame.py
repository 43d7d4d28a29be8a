"""A frame: the poses of all robots at one tick."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import numpy.typing as npt

from regatta._contract import BYTES_PER_LINE, WORDS_PER_LINE, FrameHeader
from regatta._enums import ClockState
from regatta._errors import ReadError
from regatta._ports import Bytes, Sample
from regatta._table import PUBLISHED, package, rows_of, to_html, to_pandas, to_polars

if TYPE_CHECKING:
    import pandas
    import polars

    from regatta._fleet import Fleet
    from regatta._world import World


Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, eq=False, repr=False)
class ColumnValues:
    """A reader's view of a column. ``values`` is a read-only view of shared memory.

    A reader can hold two samples of a column; to keep more, :meth:`copy` them. What a program or a notebook has shown
    (by its ``repr``) is a copy from then on.
    """

    run_id: int
    """The run that the values belong to."""
    tick: int
    """The tick that the values belong to: an older one than the frame's if the plugin that publishes them is slower."""
    values: npt.NDArray[np.float32]
    """One value per robot of that tick."""
    missed: int
    """The number of samples that were published between the one that this program got before and this one."""

    def copy(self) -> ColumnValues:
        """Returns a copy whose ``values`` are an array of its own, which can be kept and changed."""
        return replace(self, values=self.values.copy())

    def __repr__(self) -> str:
        # A notebook that shows it keeps it, in `Out[]`.
        object.__setattr__(self, "values", _owned(self.values))
        return f"<regatta.ColumnValues: tick {self.tick}, {self.values!r}>"


class Frame:
    """A reader's view of a frame in shared memory.

    Its columns are numpy arrays that are read-only views of it: nothing is copied. Row ``i`` is the robot with the id
    ``i``; the values of rows whose ``state`` is :attr:`RobotState.ABSENT <regatta.RobotState.ABSENT>` are meaningless.

    A frame and its columns stay unchanged for as long as something refers to them. A reader can hold two frames, so
    that a loop can compare each with the one before; to keep more, :meth:`copy` them, or single columns:
    ``frame.x.copy()``. A frame that a program or a notebook has shown (by its ``repr``) is a copy from then on.
    """

    __slots__ = ("_fleet", "_payload", "_published", "_words", "_world", "header", "missed")

    def __init__(self, sample: Sample[FrameHeader], fleet: Fleet) -> None:
        self.header = sample.header
        """The header, with all of the frame's metadata."""
        robots, stride = self.header.robots, self.header.stride_lines
        lines = 6 * stride + -(-stride // 4)
        if stride != -(-robots // WORDS_PER_LINE) or sample.elements < lines:
            raise ReadError(
                f"a frame of {sample.elements} lines contradicts its header ({robots} robots); its producer is at fault"
            )
        self.missed = sample.missed
        """The number of frames that were published between the one that this reader got before and this one, exactly. A
        loop with a rate skips frames on purpose; those count too."""
        self._fleet = fleet
        self._refer_to(sample.payload[: lines * BYTES_PER_LINE])
        self._world: World | None = None
        self._published: dict[str, ColumnValues] | None = None

    def __len__(self) -> int:
        """Returns the number of rows: robot ids are ``0 .. len(frame) - 1``."""
        return self.header.robots

    def copy(self) -> Frame:
        """Returns a copy with arrays of its own. It can be kept for as long as you like, and its arrays can be
        changed."""
        copy: Frame = object.__new__(Frame)
        copy.header, copy.missed, copy._fleet = self.header, self.missed, self._fleet
        copy._refer_to(self._payload.copy())
        # A later world may have replaced this frame's when the copy is asked for it.
        copy._world = self._world = self._world or self._fleet._known_world(self.header)
        copy._keep_columns(self._published_columns())
        return copy

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a copy as a data frame of pandas, which must be installed.

        It has a row per robot, without absent ones. The index ``robot`` is the robot's id. The columns are those of
        ``regatta export``: ``tick``, ``sim_time_s``, ``x_m``, ``y_m``, ``theta_rad``, ``speed_m_per_s``, ``s_m``,
        ``edge`` (its id in the route graph; missing if the robot is on none), ``state`` (a category: ``"driving"``, for
        example), and the newest values of the columns that processes publish: ``activity`` (a category: ``"carrying"``, for
        example), ``battery`` (per cent), ``collision`` (the level of the robot's worst contact, 0 without), ``goal`` (the
        id of a node), ``type`` (an index into the world's robot types) and ``waits_for`` (the id of a robot).

        Raises :class:`ReadError <regatta.ReadError>` if the producer doesn't publish the route graph.
        """
        package("pandas")
        return to_pandas(rows_of(self)).set_index("robot")

    def to_polars(self) -> polars.DataFrame:
        """Returns a copy as a data frame of polars, which must be installed. Its columns are those of
        :meth:`to_pandas`, and ``robot``. Raises the same errors."""
        package("polars")
        return to_polars(rows_of(self))

    def __str__(self) -> str:
        return f"<regatta.Frame: tick {self.tick} ({self.sim_time:.2f} s), {len(self)} robots>"

    def __repr__(self) -> str:
        self._own()
        return str(self)

    def _repr_html_(self) -> str:
        self._own()
        return to_html(self)

    @property
    def run_id(self) -> int:
        """The id of the run, which differs between any two starts of a producer."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """Ticks since the start of the run."""
        return self.header.tick

    @property
    def sim_time(self) -> float:
        """Simulated time since the start of the run, in seconds."""
        return self.header.sim_time_nanos / 1e9

    @property
    def clock(self) -> ClockState:
        """The state of the producer's clock."""
        return ClockState(self.header.clock)

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
        return self._payload[start : start + self.header.robots]

    @property
    def world(self) -> World:
        """The route graph and the robot types that this frame belongs to.

        Raises :class:`ReadError <regatta.ReadError>` if the producer doesn't publish them.
        """
        self._world = self._world or self._fleet._world_of(self.header)
        return self._world

    def column(self, name: str) -> ColumnValues | None:
        """Returns the newest values of a column, or ``None`` as long as no process has published any.

        Plugins publish columns (``collision``, for example), and so does the producer (``type``: each robot's index
        into the world's robot types). The first call opens the column, and waits a moment for the values that were
        published before. Compare the ``tick`` if the values must belong to this very frame. In lockstep they do if the
        loop comes after the plugin that publishes them: ``fleet.frames(after=["collision"])``.
        """
        return self._fleet._column_values(name)

    def _published_columns(self) -> dict[str, ColumnValues]:
        """Returns the columns of tables that processes have published for this frame's run, the newest ones; for a copy,
        those of the time when it was made."""
        if self._published is not None:
            return self._published
        return self._fleet._published_columns(self.header, PUBLISHED.values())

    def _keep_columns(self, columns: dict[str, ColumnValues]) -> None:
        """Keeps copies of columns, and that there are no others yet: processes may publish later ones."""
        self._published = {name: values.copy() for name, values in columns.items()}

    def _column(self, number: int) -> npt.NDArray[np.float32]:
        start = number * self.header.stride_lines * WORDS_PER_LINE
        return self._words[start : start + self.header.robots]

    def _refer_to(self, payload: Bytes) -> None:
        self._payload, self._words = payload, payload.view(np.float32)

    def _own(self) -> None:
        """Makes this frame a copy of itself, because a program that shows an object may keep it: a notebook's ``Out[]`` would
        hold shared memory with each frame that a cell shows."""
        self._refer_to(_owned(self._payload))
        self._keep_columns(self._published_columns())


def _owned(array: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    """Returns a read-only copy of an array, or the array itself if it holds no shared memory."""
    if array.flags.owndata:
        return array
    copy = array.copy()
    copy.flags.writeable = False
    return copy
