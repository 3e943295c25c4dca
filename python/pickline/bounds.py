"""What no strategy can exceed."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import NDArray

from pickline import _pickline
from pickline._arguments import checked
from pickline._pickline import Pattern, Station
from pickline._progress import Progress, watcher
from pickline.columns import Columns
from pickline.conditions import SearchConditions, search_conditions
from pickline.result import Result, call_text
from pickline.simulation import as_station

__all__ = ["Bound", "Prices", "bound"]


@dataclass(frozen=True, eq=False)
class Prices(Columns):
    """What picking each item costs the other items."""

    item: NDArray[np.object_]
    """Name of the item."""
    price: NDArray[np.float64]
    """Its price, in picks or in weight."""


@dataclass(frozen=True, eq=False, repr=False)
class Bound(Result):
    """What no strategy can exceed on a pattern, even one that knows the future."""

    items: int
    """Number of items in the pattern."""
    reachable: int
    """Number of items within reach of a robot."""
    picks_upper_bound: int
    """Upper bound on the picks."""
    picks_relaxed: float
    """The same before rounding down to a whole number."""
    weight_upper_bound: float | None
    """Upper bound on the sum of rewards; None if not asked for and not implied."""
    picking_rate_upper_bound_per_min: float | None
    """Upper bound on the picking rate [1/min]; None if no finite one was found."""
    weighted_rate_upper_bound_per_min: float | None
    """Upper bound on the weighted rate [1/min]."""
    end_lower_bound_s: float
    """Lower bound on the end of a run, T [s]."""
    all_picked: str
    """Whether everything can be picked: ``yes``, ``no`` (proven) or ``open``."""
    all_picked_end_lower_bound_s: float | None
    """Lower bound on the end of a run that picks everything [s]; None if there is none."""
    schedule: dict[str, Any] | None
    """The best schedule that was found, as in the program's JSON; None without one."""
    slot_s: float
    """Length of a time slot [s]."""
    stop_reason: str
    """``optimal``, ``done``, ``interrupted`` or ``too_many_items``; the bound holds in any case."""
    prices: Prices
    """``prices.csv`` of the program."""
    notes: list[str]
    """Remarks on how the figures are to be read."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        same = (
            "items",
            "reachable",
            "picks_upper_bound",
            "picks_relaxed",
            "weight_upper_bound",
            "picking_rate_upper_bound_per_min",
            "weighted_rate_upper_bound_per_min",
            "end_lower_bound_s",
            "all_picked",
            "all_picked_end_lower_bound_s",
            "schedule",
            "slot_s",
            "stop_reason",
        )
        return {name: document[name] for name in same} | dict(
            prices=Prices._read(tables["prices"]), notes=document.get("notes", [])
        )

    def __repr__(self) -> str:
        return f"<Bound: at most {self.picks_upper_bound} picks of {self.items} items>"


@checked(SearchConditions)
def bound(
    station: Station | str | os.PathLike[str],
    pattern: Pattern,
    *,
    objective: Literal["picks", "weight"] = "picks",
    slot: float | None = None,
    iterations: int = 200,
    seed: int = 1,
    progress: Progress = False,
    **under: Unpack[SearchConditions],
) -> Bound:
    """Bound what any strategy can pick from ``pattern``, as ``pickline bound`` does.

    The GIL is released.

    Args:
        station: A station, the name of a built-in one, or a station file.
        pattern: The items that arrive.
        objective: What to bound: ``"picks"``, or also the sum of rewards, ``"weight"``.
        slot: Length of the time slots [s]; shorter is tighter but slower. About a fiftieth of a pick if
            not given.
        iterations: Most updates of prices; the rate and the end take as many again.
        seed: Seed of what the camera reports.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        **under: Conditions of the run; see :class:`pickline.SearchConditions`.

    Raises:
        ValueError: A value, or a pattern that does not fit the station.
        OSError: A file that cannot be read.
        pickline.Interrupted: Ctrl-C; ``partial`` has the bound so far, which holds, too.
    """
    if objective not in ("picks", "weight"):
        raise ValueError(
            f"objective: {objective!r} cannot be bounded\n  cure: give 'picks' or 'weight'"
        )
    call = call_text(bound, locals())
    with watcher(progress) as watch:
        report = _pickline.bound(
            as_station(station),
            pattern,
            weight=objective == "weight",
            slot=slot,
            iterations=iterations,
            seed=seed,
            conditions=search_conditions(**under),
            progress=watch,
            call=call,
        )
    return Bound._of(report)
