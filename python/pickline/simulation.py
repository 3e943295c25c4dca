"""Simulating one run."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from pickline import _pickline
from pickline._arguments import checked
from pickline._pickline import Pattern, Station
from pickline._progress import Progress, watcher
from pickline._strategies import Strategy
from pickline._html import in_notebook
from pickline.columns import Columns, sealed
from pickline.conditions import Conditions, conditions
from pickline.result import KeptReport, call_text

__all__ = ["Picks", "Simulation", "simulate"]


@dataclass(frozen=True, eq=False)
class Picks(Columns):
    """Picks in order of decision, one array a column, all of shape [picks].

    ========== ======= ====================================================================
    column     dtype   meaning
    ========== ======= ====================================================================
    robot      int64   index of the robot, upstream first
    item       int64   index of the item in its pattern
    bin        int64   index of the robot's bin that the item goes into
    decide     float64 when the robot left for the item [s]
    grasp      float64 when the item leaves the belt, the start of the grasp [s]
    release    float64 when the item is in the bin and the robot is free [s]
    x, y       float64 where the item was met [m]
    ========== ======= ====================================================================
    """

    robot: NDArray[np.int64]
    item: NDArray[np.int64]
    bin: NDArray[np.int64]
    decide: NDArray[np.float64]
    grasp: NDArray[np.float64]
    release: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Simulation:
    """What came of a run, verified by the independent checker; ``print`` shows the program's tables."""

    strategy: str
    """The full name of the strategy."""
    items: int
    """Number of items that are to be picked, n."""
    picked: int
    """Number of items picked, k."""
    weight: float
    """Sum of the rewards of the picked items."""
    end: float
    """End of the run, T [s]."""
    picking_rate: float
    """60 k / T [1/min]."""
    weighted_rate: float
    """60 weight / T [1/min]."""
    picks: Picks
    """The successful picks."""
    failures: Picks
    """The failed attempts: what was intended. Empty if nothing can go wrong."""
    failure_causes: list[str]
    """Why each attempt failed: ``grasp`` or ``out_of_reach``."""
    missed: NDArray[np.int64]
    """Indices of the items that were to be picked and were not, downstream first."""
    miss_reasons: list[str]
    """Why each of them was missed."""
    left: NDArray[np.int64]
    """Indices of the items that were left on the belt on purpose."""
    robot_picked: NDArray[np.int64]
    """Number of items that each robot picked [robots]."""
    robot_failed: NDArray[np.int64]
    """Number of failed attempts of each robot [robots]."""
    robot_weight: NDArray[np.float64]
    """Sum of the rewards that each robot picked [robots]."""
    robot_busy: NDArray[np.float64]
    """Time that each robot was busy [s], [robots]."""
    bound_picked: float | None
    """What no strategy can pick more of, if asked for."""
    bound_rate: float | None
    """The picking rate that no strategy can exceed [1/min], if asked for and found."""
    notes: list[str]
    """Remarks on the settings."""
    report: _pickline.Report | KeptReport
    """The run, from which every other form is made."""

    def __post_init__(self) -> None:
        sealed(self)

    def to_csv(self) -> str:
        """The attempts as the program's CSV, with comments on where they come from."""
        return self.report.csv()

    def to_json(self) -> str:
        """Everything, as the program's JSON."""
        return self.report.json()

    def to_html(self) -> str | None:
        """The page with the run as a replay; None if there is none."""
        return self.report.page()

    def __str__(self) -> str:
        return self.report.text()

    def _repr_html_(self) -> str:
        return in_notebook(self.report.page(), self.report.text(), repr(self))

    def __repr__(self) -> str:
        return (
            f"<Simulation of {self.strategy}: {self.picked} of {self.items} items in "
            f"{self.end:.1f} s, {self.picking_rate:.1f}/min>"
        )


def as_station(station: Station | str | os.PathLike[str]) -> Station:
    """The station itself, or the one of this name or file."""
    if isinstance(station, Station):
        return station
    if not isinstance(station, str | os.PathLike):
        raise TypeError(
            f"station: {station!r} is not a station\n"
            "  cure: give a Station, the name of a built-in one, or a station file"
        )
    return Station(station)


@checked(Conditions)
def simulate(
    station: Station | str | os.PathLike[str],
    pattern: Pattern,
    strategy: Strategy = "SPT,FIFO",
    *,
    seed: int = 1,
    bound: bool = False,
    progress: Progress = False,
    **under: Unpack[Conditions],
) -> Simulation:
    """Simulate ``strategy`` on ``pattern`` and verify the run with the independent checker.

    The GIL is released. Ctrl-C ends the run at its next decision.

    Args:
        station: A station, the name of a built-in one, or a station file.
        pattern: The items that arrive.
        strategy: As after ``--strategy`` of the program: rules such as ``SPT,FIFO``, ``lookahead``,
            ``onnx``, ``onnx:FILE``; or a callable, see :mod:`pickline.strategy`. It is called with the
            GIL; what it raises comes out as itself.
        seed: Seed of everything random in the run, and of the search for bases.
        bound: Whether to also find what no strategy can exceed.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of the run; see :class:`pickline.Conditions`.

    Raises:
        ValueError: A value, a strategy or a pattern that does not fit the station, or an action of a
            callable that is not one.
        OSError: A file that cannot be read.
        KeyboardInterrupt: Ctrl-C.
    """
    if not isinstance(pattern, Pattern):
        raise TypeError(
            f"pattern: {pattern!r} is not a pattern\n  cure: give a Pattern, such as one of "
            "pickline.patterns(source, station), or Pattern.from_csv(file)"
        )
    call = call_text(simulate, locals())
    with watcher(progress) as watch:
        parts = _pickline.simulate(
            as_station(station), pattern, strategy, conditions(**under), seed, bound, watch, call
        )
    return Simulation(
        strategy=parts["strategy"],
        **parts["figures"],
        picks=Picks(**parts["picks"]),
        failures=Picks(**parts["failures"]),
        failure_causes=parts["causes"],
        missed=parts["missed"],
        miss_reasons=parts["reasons"],
        left=parts["left"],
        robot_picked=parts["robot_picked"],
        robot_failed=parts["robot_failed"],
        robot_weight=parts["robot_weight"],
        robot_busy=parts["robot_busy"],
        bound_picked=parts["bound_picked"],
        bound_rate=parts["bound_rate"],
        notes=parts["notes"],
        report=parts["run"],
    )
