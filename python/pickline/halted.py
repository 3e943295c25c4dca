"""A line with each of its robots halted in turn."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Unpack

from pickline import _pickline
from pickline._arguments import checked
from pickline._patterns import Patterns, as_given
from pickline._pickline import Station
from pickline._progress import Progress, watcher
from pickline._strategies import Strategies, as_strategies
from pickline.columns import Columns, Numbers, Texts
from pickline.conditions import Conditions, conditions
from pickline.result import Result, call_text, partial
from pickline.simulation import as_station

__all__ = ["HaltedPoints", "RobotsDown", "robots_down"]


@dataclass(frozen=True, eq=False)
class HaltedPoints(Columns):
    """Every method with no robot halted, then with each."""

    robot_down: Texts
    """Name of the robot that is down for the whole run, empty if all work."""
    method: Texts
    """Name of the method."""
    throughput_per_min: Numbers | None
    """Picks per minute in the steady state [1/min]; NaN without one."""
    throughput_low_per_min: Numbers | None
    """Lower end of its 95 % interval [1/min]."""
    throughput_high_per_min: Numbers | None
    """Upper end of its 95 % interval [1/min]."""
    flow_per_min: Numbers | None
    """Items that arrive per minute [1/min]."""
    picked_share: Numbers
    """Mean share of the items that is picked, 0 to 1."""
    picked_share_low: Numbers | None
    """Lower end of its 95 % interval."""
    picked_share_high: Numbers | None
    """Upper end of its 95 % interval."""
    picking_rate_per_min: Numbers
    """Mean of 60 k / T [1/min]."""
    picking_rate_low_per_min: Numbers | None
    """Lower end of its 95 % interval [1/min]."""
    picking_rate_high_per_min: Numbers | None
    """Upper end of its 95 % interval [1/min]."""
    loss_percent: Numbers | None
    """How many fewer items are picked than if all robots work [%]; NaN if all work."""
    loss_low_percent: Numbers | None
    """Lower end of its 95 % interval, paired over patterns [%]."""
    loss_high_percent: Numbers | None
    """Upper end of that interval [%]."""
    weighted_rate_per_min: Numbers | None
    """60 sum(r) / T [1/min]; only where items have attributes."""


@dataclass(frozen=True, eq=False, repr=False)
class RobotsDown(Result):
    """What a line still does while one of its robots is down for the whole run."""

    patterns: int
    """Number of patterns."""
    points: HaltedPoints
    """``sweep.csv`` of the program."""
    notes: list[str]
    """Remarks on how the figures are to be read."""
    partial: str | None
    """How far the work got, if it was interrupted."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        return dict(
            patterns=document["patterns"],
            points=HaltedPoints._read(tables["sweep"]),
            notes=document["notes"],
            partial=partial(document),
        )

    def __repr__(self) -> str:
        robots = len(set(self.points.robot_down) - {""})
        return f"<RobotsDown: {robots} robots, each halted, on {self.patterns} patterns>"


@checked(Conditions)
def robots_down(
    station: Station | str | os.PathLike[str] = "paper",
    patterns: Patterns = "grid:0.15",
    *,
    strategy: Strategies = (),
    items: int | None = None,
    flow: float | None = None,
    cluster_size: float | None = None,
    cluster_spread: float | None = None,
    gap_length: float | None = None,
    gap_share: float | None = None,
    robust: str | None = None,
    train_patterns: str | None = None,
    train_items: int | None = None,
    greedy: bool = False,
    tune: bool = False,
    area: str | None = None,
    p_detection: str | None = None,
    p_grasp: str | None = None,
    classes: str | None = None,
    seed: int = 1,
    progress: Progress = False,
    **under: Unpack[Conditions],
) -> RobotsDown:
    """Halt each robot in turn and see what the line still does, as ``pickline sweep --sweep robots-down``
    does.

    Rules and strategies are those of the whole line. The GIL is released.

    Args:
        station: A station, the name of a built-in one, or a station file. Unlike the program, a strategy
            that the file names is not added.
        patterns: Source of the patterns, as for :func:`pickline.patterns`; or a pattern, or several.
        strategy: Further strategies, each as after ``--strategy`` of the program, or a callable; see
            :mod:`pickline.strategy`. Callables are called from several threads.
        items: Items in each generated pattern; as many as a steady state needs if not given.
        flow: Items per minute of a feed that does not say so [1/min].
        cluster_size: Shape of a feed, as are the three after it; see :func:`pickline.patterns`.
        robust: Rules for robust GT instead of a search, such as ``"SPT,FIFO"``.
        train_patterns: Training set of robust GT; patterns like those that are run if not given.
        train_items: Items in each pattern of the training set.
        greedy: Whether to add greedy GT, the best assignment for each single pattern.
        tune: Whether to add the best of what line software ships (shares, every n-th item, zones, FIFO for
            all), tuned on training patterns for the whole line; its name is ``"rival"``.
        area: Distribution of the areas of generated items [cm^2], such as ``"lognormal:80,0.5"``.
        p_detection: Distribution of their probability that the detection is a real item.
        p_grasp: Distribution of their probability that a grasp succeeds.
        classes: Their classes and shares, such as ``"pet:0.6,wood:0.4"``.
        seed: Seed of everything random.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of every run; see :class:`pickline.Conditions`. ``misdetections`` is not among
            them.

    Raises:
        ValueError: A value, a strategy or patterns that do not fit the station.
        OSError: A file that cannot be read.
        pickline.Interrupted: Ctrl-C; ``partial`` has the robots that were halted by then.
        KeyboardInterrupt: Ctrl-C before the whole line had been run.
    """
    if under.get("misdetections"):
        raise ValueError(
            "misdetections: does not apply to robots that are down, of which no purity is reported\n"
            "  cure: leave it out"
        )
    call = call_text(robots_down, locals())
    feed = dict(
        flow=flow,
        cluster_size=cluster_size,
        cluster_spread=cluster_spread,
        gap_length=gap_length,
        gap_share=gap_share,
    )
    with watcher(progress) as watch:
        report = _pickline.robots_down(
            as_station(station),
            strategy=as_strategies(strategy),
            patterns=as_given(patterns),
            items=items,
            feed=feed,
            robust=robust,
            train_patterns=train_patterns,
            train_items=train_items,
            greedy=greedy,
            tune=tune,
            area=area,
            p_detection=p_detection,
            p_grasp=p_grasp,
            classes=classes,
            seed=seed,
            conditions=conditions(**under),
            progress=watch,
            call=call,
        )
    return RobotsDown._of(report)
