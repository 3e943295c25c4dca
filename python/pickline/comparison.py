"""Methods compared on cases."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Unpack

from pickline import _pickline
from pickline._arguments import checked
from pickline._patterns import Cases, as_cases
from pickline._pickline import Station
from pickline._progress import Progress, watcher
from pickline._strategies import Strategies, as_strategies
from pickline.columns import Columns, Counts, Numbers, Texts
from pickline.conditions import Conditions, conditions
from pickline.purity import Purities
from pickline.result import Result, call_text, partial
from pickline.simulation import as_station

__all__ = [
    "CaseClasses",
    "CasePurities",
    "Comparison",
    "PickedTimes",
    "PickingRates",
    "Runs",
    "Throughputs",
    "compare",
]


@dataclass(frozen=True, eq=False)
class PickingRates(Columns):
    """The picking rate of every method on every case; Table 3 of the paper."""

    case: Texts
    """Name of the case."""
    method: Texts
    """Name of the method: ``robust_gt``, ``greedy_gt`` or a strategy as it is written."""
    picking_rate_per_min: Numbers
    """Mean of 60 k / T [1/min]."""
    picking_rate_low_per_min: Numbers
    """Lower end of its 95 % interval [1/min]."""
    picking_rate_high_per_min: Numbers
    """Upper end of its 95 % interval [1/min]."""
    benefit_percent: Numbers
    """Excess over the first method [%]."""
    diff_low_per_min: Numbers
    """Lower end of the 95 % interval of the paired difference from the first method [1/min]."""
    diff_high_per_min: Numbers
    """Upper end of that interval [1/min]."""
    picking_rate_upper_bound_per_min: Numbers
    """What no strategy can exceed [1/min]."""
    patterns: Counts
    """Number of patterns of the case."""


@dataclass(frozen=True, eq=False)
class Throughputs(Columns):
    """The steady state of every method on every case."""

    case: Texts
    """Name of the case."""
    method: Texts
    """Name of the method."""
    throughput_per_min: Numbers
    """Picks per minute in the steady state [1/min]; NaN without one."""
    throughput_low_per_min: Numbers
    """Lower end of its 95 % interval [1/min]."""
    throughput_high_per_min: Numbers
    """Upper end of its 95 % interval [1/min]."""
    flow_per_min: Numbers
    """Items that arrive per minute [1/min]."""
    steady_patterns: Counts
    """Number of patterns on which a steady state is reached."""
    patterns: Counts
    """Number of patterns of the case."""


@dataclass(frozen=True, eq=False)
class PickedTimes(Columns):
    """How much every method picks of every case, and how long that takes; Table 2 of the paper."""

    case: Texts
    """Name of the case."""
    method: Texts
    """Name of the method."""
    picked_share: Numbers
    """Mean share of the items that is picked, 0 to 1."""
    end_s: Numbers
    """Mean end of a run, T [s]."""
    patterns: Counts
    """Number of patterns of the case."""


@dataclass(frozen=True, eq=False)
class Runs(Columns):
    """Every run of a comparison: a method on a pattern."""

    case: Texts
    """Name of the case."""
    pattern_seed: Counts
    """Seed of the pattern."""
    method: Texts
    """Name of the method."""
    items: Counts
    """Number of items that are to be picked, n."""
    picked: Counts
    """Number of items picked, k."""
    end_s: Numbers
    """End of the run, T [s]."""
    throughput_per_min: Numbers
    """Picks per minute in the steady state [1/min]; NaN without one."""
    flow_per_min: Numbers
    """Items that arrive per minute [1/min]."""
    picking_rate_per_min: Numbers
    """60 k / T [1/min]."""
    picks_upper_bound: Counts | Numbers
    """What no strategy can pick more of."""
    assignment: Texts
    """The rules, upstream first, of methods that are rules."""
    rightly_binned: Counts | None
    """Number of items that are what their bin is for; only where detections may be wrong."""
    due: Counts | None
    """Number of items that belong into a bin; only where detections may be wrong."""
    weighted_rate_per_min: Numbers | None
    """60 sum(r) / T [1/min]; only where items have attributes."""


@dataclass(frozen=True, eq=False)
class _CaseBins(Columns):
    """What a row of purities is about."""

    case: Texts
    """Name of the case."""
    method: Texts
    """Name of the method."""
    bin: Texts
    """Name of the bin, empty for all together."""


@dataclass(frozen=True, eq=False)
class CasePurities(Purities, _CaseBins):
    """Purity and recovery of the bins, for every method on every case."""


@dataclass(frozen=True, eq=False)
class CaseClasses(Columns):
    """What every method picks of each class of items on every case."""

    case: Texts
    """Name of the case."""
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
    patterns: Counts
    """Number of patterns of the case."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Methods on cases; the others are compared with the first one."""

    methods: list[str]
    """Names of the methods, as in the tables."""
    cases: list[str]
    """Names of the cases that were completed."""
    picking_rate: PickingRates
    """``picking_rate.csv`` of the program."""
    throughput: Throughputs
    """``throughput.csv`` of the program."""
    picked_time: PickedTimes
    """``picked_time.csv`` of the program."""
    runs: Runs
    """``runs.csv`` of the program."""
    purity: CasePurities | None
    """``purity.csv`` of the program; None if detections cannot be wrong."""
    classes: CaseClasses | None
    """``classes.csv`` of the program; None if there are no classes."""
    notes: list[str]
    """Remarks on how the figures are to be read."""
    partial: str | None
    """How far the work got, if it was interrupted."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        return dict(
            methods=[method["id"] for method in document["methods"]],
            cases=[case["name"] for case in document["cases"]],
            picking_rate=PickingRates._read(tables["picking_rate"]),
            throughput=Throughputs._read(tables["throughput"]),
            picked_time=PickedTimes._read(tables["picked_time"]),
            runs=Runs._read(tables["runs"]),
            purity=CasePurities._read_any(tables.get("purity")),
            classes=CaseClasses._read_any(tables.get("classes")),
            notes=document["notes"],
            partial=partial(document),
        )

    def __repr__(self) -> str:
        cases = f"{len(self.cases)} cases, {len(self.runs)} runs"
        return f"<Comparison of {', '.join(self.methods)} on {cases}>"


@checked(Conditions)
def compare(
    station: Station | str | os.PathLike[str] = "paper",
    cases: Cases = "paper",
    *,
    strategy: Strategies = (),
    replicates: int = 100,
    reference: str = "robust_gt",
    robust: str | None = None,
    train_patterns: str | None = None,
    train_items: int | None = None,
    paper: bool = False,
    greedy: bool = True,
    policy: bool = True,
    bound: bool = True,
    tune: bool = False,
    area: str | None = None,
    p_detection: str | None = None,
    p_grasp: str | None = None,
    classes: str | None = None,
    seed: int = 1,
    progress: Progress = False,
    **under: Unpack[Conditions],
) -> Comparison:
    """Compare strategies on the paper's cases or your own, as ``pickline compare`` does.

    Robust GT is the assignment of rules that is best over a training set; greedy GT is the best one for
    each single pattern; the third is the trained policy that ships with the package. Differences are
    paired over patterns. The GIL is released.

    Args:
        station: A station, the name of a built-in one, or a station file. Unlike the program, a strategy
            that the file names is not added.
        cases: ``"paper"``, ``"dense"``, ``"all"``, or a TOML file (``pickline help compare``); or a
            pattern or several, which are one case; or a dictionary of cases by their names.
        strategy: Further strategies, each as after ``--strategy`` of the program, or a callable; see
            :mod:`pickline.strategy`. Callables are called from several threads.
        replicates: Number of patterns of each random case; if something can go wrong, of runs of each
            case.
        reference: The method that the others are compared with, by its name in tables.
        robust: Rules for robust GT instead of a search, such as ``"SPT,FIFO"``.
        train_patterns: Training set of robust GT, such as ``"balanced:20"``; patterns like those of the
            cases if not given.
        train_items: Items in each pattern of the training set.
        paper: Whether to find robust GT on the paper's balanced set.
        greedy: Whether to compare greedy GT; it is always left out if it would take minutes.
        policy: Whether to compare the trained policy that ships with the package; it is always left out
            if another policy is compared or if the line is far from its training.
        bound: Whether to find what no strategy can exceed.
        tune: Whether to add the best of what line software ships (shares, every n-th item, zones, FIFO for
            all), tuned on training patterns; its name is ``"rival"``.
        area: Distribution of the areas of generated items [cm^2], such as ``"lognormal:80,0.5"``.
        p_detection: Distribution of their probability that the detection is a real item.
        p_grasp: Distribution of their probability that a grasp succeeds.
        classes: Their classes and shares, such as ``"pet:0.6,wood:0.4"``.
        seed: Seed of everything random.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of every run; see :class:`pickline.Conditions`.

    Raises:
        ValueError: A value, a strategy or a case that does not fit the station.
        OSError: A file that cannot be read.
        pickline.Interrupted: Ctrl-C; ``partial`` has the cases that were completed.
        KeyboardInterrupt: Ctrl-C before the first case was complete.
    """
    call = call_text(compare, locals())
    with watcher(progress) as watch:
        report = _pickline.compare(
            as_station(station),
            as_cases(cases),
            strategy=as_strategies(strategy),
            replicates=replicates,
            reference=reference,
            robust=robust,
            train_patterns=train_patterns,
            train_items=train_items,
            paper=paper,
            greedy=greedy,
            policy=policy,
            bound=bound,
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
    return Comparison._of(report)
