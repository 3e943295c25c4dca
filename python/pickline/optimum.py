"""The search for the best assignment of rules."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import NDArray

from pickline import _pickline
from pickline._arguments import checked
from pickline._patterns import Patterns, as_given
from pickline._pickline import Station
from pickline._progress import Progress, watcher
from pickline._strategies import Strategies, as_strategies
from pickline.columns import Columns, Counts, Numbers, Texts
from pickline.conditions import SearchConditions, conditions
from pickline.result import Result, call_text, partial
from pickline.simulation import as_station

__all__ = ["Optimum", "Ranking", "ScoredStrategies", "optimize"]


@dataclass(frozen=True, eq=False)
class Ranking(Columns):
    """Assignments of rules, best first.

    Figures of the objective are in its unit; CSV files name them after it, such as
    ``picking_rate_mean_per_min``.
    """

    rank: Counts
    """Place in the ranking, from 1."""
    assignment: Texts
    """The rules, upstream first, such as ``"SPT FIFO"``."""
    mean: Numbers
    """Mean of the objective over the patterns."""
    value: Numbers
    """The objective as the patterns are combined."""
    diff_low: Numbers | None
    """Lower end of the 95 % interval of the paired difference from the best."""
    diff_high: Numbers | None
    """Upper end of that interval."""
    tied: NDArray[np.bool_]
    """Whether nothing tells it from the best."""
    picked_share: Numbers
    """Mean share of the items that is picked, 0 to 1."""
    worst: Numbers
    """The objective on the worst pattern."""
    worst_pattern: Texts
    """Which pattern that is."""
    max_speed_m_per_s: Numbers | None
    """Highest belt speed at which everything is picked [m/s], where ties were broken by it."""


@dataclass(frozen=True, eq=False)
class ScoredStrategies(Columns):
    """The winner and other strategies on the same patterns."""

    strategy: Texts
    """The strategy; the first is the winner."""
    mean: Numbers
    """Mean of the objective over the patterns."""
    value: Numbers
    """The objective as the patterns are combined."""
    diff_low: Numbers
    """Lower end of the 95 % interval of the paired difference from the winner."""
    diff_high: Numbers
    """Upper end of that interval."""
    picked_share: Numbers
    """Mean share of the items that is picked, 0 to 1."""
    worst: Numbers
    """The objective on the worst pattern."""
    patterns: Counts
    """Number of patterns."""


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Result):
    """The best assignment of rules, and what it is worth."""

    best: list[str]
    """The winner's rules, upstream first."""
    objective: str
    """What was maximised."""
    unit: str
    """Its unit."""
    stop_reason: str
    """Why the search ended, in snake case: ``enumerated``, ``proven``, ``local_optima``, ``budget``,
    ``time_limit`` or ``interrupted``.
    """
    proof: dict[str, Any] | None
    """What branch and bound proved, as in the program's JSON: no assignment scores above ``most``, which
    is ``gap`` above the highest score found; None if it did not run.
    """
    runs: int
    """Number of simulated runs: one assignment on one pattern at one belt speed each."""
    ranking: Ranking
    """``ranking.csv`` of the program."""
    validation: dict[str, Any] | None
    """The winner on fresh patterns, as in the program's JSON; None without them."""
    strategies: ScoredStrategies | None
    """``strategies.csv`` of the program; None without further strategies."""
    notes: list[str]
    """Remarks on how the figures are to be read."""
    partial: str | None
    """How far the search got, if it was interrupted."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        same = ("best", "objective", "unit", "stop_reason", "runs", "validation", "notes")
        return {name: document[name] for name in same} | dict(
            ranking=Ranking._read(tables["ranking"]),
            proof=document.get("proof"),
            strategies=ScoredStrategies._read_any(tables.get("strategies")),
            partial=partial(document),
        )

    @property
    def strategy(self) -> str:
        """The winner as a strategy of :func:`pickline.simulate`."""
        return f"rules:{','.join(self.best)}"

    def __repr__(self) -> str:
        mean = self.ranking.mean[0]
        return f"<Optimum {self.strategy}: mean {self.objective} {mean:.4g} {self.unit}>"


@checked(SearchConditions)
def optimize(
    station: Station | str | os.PathLike[str] = "paper",
    patterns: Patterns = "balanced:120",
    *,
    strategy: Strategies = (),
    items: int | None = None,
    flow: float | None = None,
    cluster_size: float | None = None,
    cluster_spread: float | None = None,
    gap_length: float | None = None,
    gap_share: float | None = None,
    objective: Literal["picking-rate", "picked-share", "weighted-rate", "max-speed"] = "picking-rate",
    risk: str = "mean",
    search: Literal["auto", "exhaustive", "grasp", "both", "exact"] = "auto",
    starts: int = 8,
    alpha: float = 0.3,
    speed_step: float = 0.001,
    max_runs: int | None = None,
    time_limit: float | None = None,
    validate: int | None = None,
    bound: bool = True,
    area: str | None = None,
    p_detection: str | None = None,
    p_grasp: str | None = None,
    classes: str | None = None,
    seed: int = 1,
    progress: Progress = False,
    **under: Unpack[SearchConditions],
) -> Optimum:
    """Find the rule for each robot that picks best over patterns, as ``pickline optimize`` does.

    The GIL is released.

    Args:
        station: A station, the name of a built-in one, or a station file.
        patterns: Source of the patterns, as for :func:`pickline.patterns`; or a pattern, or several. Of
            patterns that are given there are no fresh ones to score the winner on.
        strategy: Further strategies to score beside the winner, each as after ``--strategy`` of the
            program, or a callable; see :mod:`pickline.strategy`. Callables are called from several
            threads.
        items: Items in each generated pattern; 150 if not given.
        flow: Items per minute of a feed that does not say so [1/min].
        cluster_size: Shape of a feed, as are the three after it; see :func:`pickline.patterns`.
        objective: What to maximise: ``"picking-rate"`` [1/min], ``"picked-share"``, ``"weighted-rate"``
            [1/min] or ``"max-speed"`` [m/s].
        risk: How the patterns are combined: ``"mean"``, ``"worst"``, or ``"cvar:A"``, the mean of the
            worst share A.
        search: ``"auto"``, ``"exhaustive"``, ``"grasp"``, ``"both"`` or ``"exact"``.
        starts: Number of starts of GRASP.
        alpha: Width of the restricted candidate list of GRASP, 0 (greedy) to 1 (random).
        speed_step: Resolution of the speed limits that break ties [m/s].
        max_runs: Most simulated runs of the search; 0 for any number, a usual number if not given.
        time_limit: Stop the search after this time [s]; the result then depends on the machine.
        validate: Number of fresh patterns to score the winner on; 0 for none, up to 1000 if not given.
        bound: Whether to bound how far the winner is from the best that any strategy can do.
        area: Distribution of the areas of generated items [cm^2], such as ``"lognormal:80,0.5"``.
        p_detection: Distribution of their probability that the detection is a real item.
        p_grasp: Distribution of their probability that a grasp succeeds.
        classes: Their classes and shares, such as ``"pet:0.6,wood:0.4"``.
        seed: Seed of everything random.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of every run; see :class:`pickline.SearchConditions`.

    Raises:
        ValueError: A value, a strategy or patterns that do not fit the station.
        OSError: A file that cannot be read.
        pickline.Interrupted: Ctrl-C; ``partial`` has the best so far.
        KeyboardInterrupt: Ctrl-C before there was a result.
    """
    call = call_text(optimize, locals())
    feed = dict(
        flow=flow,
        cluster_size=cluster_size,
        cluster_spread=cluster_spread,
        gap_length=gap_length,
        gap_share=gap_share,
    )
    with watcher(progress) as watch:
        report = _pickline.optimize(
            as_station(station),
            strategy=as_strategies(strategy),
            patterns=as_given(patterns),
            items=items,
            feed=feed,
            objective=objective,
            risk=risk,
            search=search,
            starts=starts,
            alpha=alpha,
            speed_step=speed_step,
            max_runs=max_runs,
            time_limit=time_limit,
            validate=validate,
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
    return Optimum._of(report)
