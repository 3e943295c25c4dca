"""One quantity of the line varied."""

from __future__ import annotations

import difflib
import os
from dataclasses import dataclass
from typing import Any, Literal, Self, Unpack, get_args

import numpy as np

from pickline import _pickline
from pickline._arguments import checked
from pickline._patterns import Patterns, as_given
from pickline._pickline import Station
from pickline._progress import Progress, watcher
from pickline._strategies import Strategies, as_strategies
from pickline.columns import Columns, Counts, Numbers, Texts, texts
from pickline.conditions import Conditions, conditions
from pickline.purity import Purities
from pickline.result import Result, call_text, partial
from pickline.simulation import as_station

__all__ = ["Limits", "Points", "Sweep", "SweptClasses", "SweptPurities", "Thresholds", "sweep"]


Quantity = Literal["speed", "robots", "spacing", "reach", "min-detection"]


@dataclass(frozen=True, eq=False)
class Points(Columns):
    """Every method at every value."""

    value: Numbers
    """The varied quantity, in its unit; named after it in CSV files, such as ``belt_speed_m_per_s``."""
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
    added_per_robot_per_min: Numbers | None
    """What each further robot adds to the throughput [1/min]; only in a sweep of robots."""
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
    complete_share: Numbers
    """Share of the patterns that are picked completely, 0 to 1."""
    nearly_complete_share: Numbers
    """Share of the patterns of which at least 99 % is picked, 0 to 1."""
    certified_percent: Numbers | None
    """Picks as a proven share of the optimum [%]."""
    picked_share_upper_bound: Numbers | None
    """What no strategy can exceed, 0 to 1."""
    picking_rate_upper_bound_per_min: Numbers | None
    """What no strategy can exceed [1/min]."""
    weighted_rate_per_min: Numbers | None
    """60 sum(r) / T [1/min]; only where items have attributes."""
    purity: Numbers | None
    """Share of what is binned that belongs there, 0 to 1; only where detections may be wrong."""
    purity_low: Numbers | None
    """Lower end of its 95 % interval."""
    purity_high: Numbers | None
    """Upper end of its 95 % interval."""
    recovery: Numbers | None
    """Share of what is due that is binned rightly, 0 to 1; only where detections may be wrong."""
    recovery_low: Numbers | None
    """Lower end of its 95 % interval."""
    recovery_high: Numbers | None
    """Upper end of its 95 % interval."""


@dataclass(frozen=True, eq=False)
class _SweptBins(Columns):
    """What a row of purities is about."""

    value: Numbers
    """The varied quantity, in its unit."""
    method: Texts
    """Name of the method."""
    bin: Texts
    """Name of the bin, empty for all together."""


@dataclass(frozen=True, eq=False)
class SweptPurities(Purities, _SweptBins):
    """Purity and recovery of the bins, for every method at every value."""


@dataclass(frozen=True, eq=False)
class _Choices(Columns):
    """What was chosen for a method, and on which patterns a row is."""

    method: Texts
    """Name of the method."""
    wanted_purity: Numbers
    """The purity that was asked for, 0 to 1."""
    min_detection: Numbers
    """The threshold; NaN if none gives that purity."""
    patterns: Texts
    """``training`` for the patterns that it was chosen on, ``fresh`` for others."""


@dataclass(frozen=True, eq=False)
class Thresholds(Purities, _Choices):
    """The threshold of detections chosen for every method, and what it gives."""


@dataclass(frozen=True, eq=False)
class SweptClasses(Columns):
    """What every method picks of each class of items at every value."""

    value: Numbers
    """The varied quantity, in its unit."""
    method: Texts
    """Name of the method."""
    item_class: Texts
    """Name of the class, empty for items without one; ``class`` in CSV files."""
    items: Counts
    """Number of items of the class."""
    picked: Counts
    """Number of those that are picked."""
    recovery: Numbers
    """Their share, 0 to 1; NaN if they are not to be picked."""
    recovery_low: Numbers
    """Lower end of its 95 % interval."""
    recovery_high: Numbers
    """Upper end of its 95 % interval."""
    picks_upper_bound: Counts | Numbers
    """What no strategy can pick more of."""
    certified_percent: Numbers
    """Picks as a proven share of the optimum [%]."""


@dataclass(frozen=True, eq=False)
class Limits(Columns):
    """Up to which value each method picks everything."""

    method: Texts
    """Name of the method."""
    highest: Numbers
    """Highest value up to which every item of every pattern is picked; NaN if there is none."""
    first_miss: Numbers
    """First value at which an item is missed."""
    lowest: Numbers
    """Lowest value from which every item of every pattern is picked."""
    highest_95_99: Numbers
    """Highest value up to which at least 99 % is picked of 95 % of the patterns."""
    benefit_percent: Numbers
    """Excess of ``highest`` over that of the first method [%]."""
    recommended: Numbers
    """The recommended value; NaN in a sweep of the speed."""

    @classmethod
    def _of(cls, limits: list[dict[str, Any]]) -> Self:
        numbers = (
            "highest",
            "first_miss",
            "lowest",
            "highest_95_99",
            "benefit_percent",
            "recommended",
        )
        columns = {name: np.array([limit[name] for limit in limits], float) for name in numbers}
        return cls(method=texts([limit["method"] for limit in limits]), **columns)


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Result):
    """Methods at the values of one quantity of the line."""

    sweep: str
    """The quantity: ``speed``, ``robots``, ``spacing``, ``reach`` or ``min-detection``."""
    unit: str
    """Its unit."""
    patterns: int
    """Number of patterns at each value."""
    points: Points
    """``sweep.csv`` of the program."""
    limits: Limits
    """Up to which value each method picks everything."""
    purity: SweptPurities | None
    """``purity.csv`` of the program; None if detections cannot be wrong."""
    thresholds: Thresholds | None
    """``thresholds.csv`` of the program; None without a wanted purity."""
    classes: SweptClasses | None
    """``classes.csv`` of the program; None if there are no classes."""
    notes: list[str]
    """Remarks on how the figures are to be read."""
    partial: str | None
    """How far the work got, if it was interrupted."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        return dict(
            sweep=document["sweep"],
            unit=document["unit"],
            patterns=document["patterns"],
            points=Points._read(tables["sweep"]),
            limits=Limits._of(document["limits"]),
            purity=SweptPurities._read_any(tables.get("purity")),
            thresholds=Thresholds._read_any(tables.get("thresholds")),
            classes=SweptClasses._read_any(tables.get("classes")),
            notes=document["notes"],
            partial=partial(document),
        )

    def __repr__(self) -> str:
        values = np.unique(self.points.value)
        over = f"{len(values)} values from {values[0]:g} to {values[-1]:g} {self.unit}"
        return f"<Sweep of {self.sweep} over {over.strip()}>"


@checked(Conditions)
def sweep(
    station: Station | str | os.PathLike[str] = "paper",
    sweep: Quantity = "speed",
    *,
    strategy: Strategies = (),
    patterns: Patterns = "grid:0.15",
    items: int | None = None,
    flow: float | None = None,
    cluster_size: float | None = None,
    cluster_spread: float | None = None,
    gap_length: float | None = None,
    gap_share: float | None = None,
    from_: float | None = None,
    to: float | None = None,
    step: float | None = None,
    purity: float | None = None,
    robust: str | None = None,
    train_patterns: str | None = None,
    train_items: int | None = None,
    greedy: bool = False,
    tune: bool = False,
    bound: bool = True,
    area: str | None = None,
    p_detection: str | None = None,
    p_grasp: str | None = None,
    classes: str | None = None,
    seed: int = 1,
    progress: Progress = False,
    **under: Unpack[Conditions],
) -> Sweep:
    """Vary one quantity of the line and run strategies at every value, as ``pickline sweep`` does.

    The GIL is released.

    Args:
        station: A station, the name of a built-in one, or a station file. A sweep of robots makes it
            again from that name, or from the text that the file had. Unlike the program, a strategy that
            the file names is not added.
        sweep: The quantity: ``"speed"`` of the belt, number of ``"robots"``, ``"spacing"``, ``"reach"``,
            or ``"min-detection"``, the threshold of detections. :func:`pickline.robots_down` halts robots.
        strategy: Further strategies, each as after ``--strategy`` of the program, or a callable; see
            :mod:`pickline.strategy`. Callables are called from several threads.
        patterns: Source of the patterns, as for :func:`pickline.patterns`; or a pattern, or several.
        items: Items in each generated pattern; as many as needed if not given.
        flow: Items per minute of a feed that does not say so [1/min].
        cluster_size: Shape of a feed, as are the three after it; see :func:`pickline.patterns`.
        from_: First value, in the unit of the quantity.
        to: Last value.
        step: Step between values; a round one that gives up to 30 values if not given.
        purity: In a sweep of min-detection, the purity for which a threshold is chosen, 0 to 1.
        robust: Rules for robust GT instead of a search, such as ``"SPT,FIFO"``.
        train_patterns: Training set of robust GT; patterns like those that are swept if not given.
        train_items: Items in each pattern of the training set.
        greedy: Whether to add greedy GT, the best assignment for each single pattern.
        tune: Whether to add the best of what line software ships (shares, every n-th item, zones, FIFO for
            all), tuned on training patterns for every line; its name is ``"rival"``.
        bound: Whether to find what no strategy can exceed.
        area: Distribution of the areas of generated items [cm^2], such as ``"lognormal:80,0.5"``.
        p_detection: Distribution of their probability that the detection is a real item.
        p_grasp: Distribution of their probability that a grasp succeeds.
        classes: Their classes and shares, such as ``"pet:0.6,wood:0.4"``.
        seed: Seed of everything random.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of every run; see :class:`pickline.Conditions`.

    Raises:
        ValueError: A value, a strategy or a range that does not fit the station.
        OSError: A file that cannot be read.
        pickline.Interrupted: Ctrl-C; ``partial`` has the values that were completed.
        KeyboardInterrupt: Ctrl-C before the first value was complete.
    """
    if sweep not in get_args(Quantity):
        if str(sweep) == "robots-down":
            raise ValueError(
                "sweep: 'robots-down' has no values, but robots\n  cure: call pickline.robots_down"
            )
        near = difflib.get_close_matches(str(sweep), get_args(Quantity), 1)
        cure = f"did you mean `{near[0]}`?" if near else f"give one of {', '.join(get_args(Quantity))}"
        raise ValueError(f"sweep: {sweep!r} is not a quantity\n  cure: {cure}")
    call = call_text(_sweep, locals())
    feed = dict(
        flow=flow,
        cluster_size=cluster_size,
        cluster_spread=cluster_spread,
        gap_length=gap_length,
        gap_share=gap_share,
    )
    with watcher(progress) as watch:
        report = _pickline.sweep(
            as_station(station),
            sweep,
            strategy=as_strategies(strategy),
            patterns=as_given(patterns),
            items=items,
            feed=feed,
            from_=from_,
            to=to,
            step=step,
            purity=purity,
            robust=robust,
            train_patterns=train_patterns,
            train_items=train_items,
            greedy=greedy,
            tune=tune,
            bound=bound,
            area=area,
            p_detection=p_detection,
            p_grasp=p_grasp,
            classes=classes,
            seed=seed,
            conditions=conditions(**under),
            progress=watch,
            call=call,
        )
    return Sweep._of(report)


# The argument hides the function.
_sweep = sweep
