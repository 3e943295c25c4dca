"""The Rust side: stations, patterns and environments."""

import os
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
OBSERVATION_VERSION: int

class Station:
    """A belt and the robots along it; it cannot be changed.

    Args:
        name: The name of a built-in station (``Station.built_in()``), or a station file. A file with
            that name comes first.
        robots: Number of identical robots on the line; as many as the station has if not given.
        belt_speed: Speed of the belt [m/s]; the station's if not given.

    Raises:
        ValueError: An unknown name, or a value that the model does not allow.
        OSError: A file that cannot be read.
    """

    def __new__(
        cls,
        name: str | os.PathLike[str] = "paper",
        *,
        robots: int | None = None,
        belt_speed: float | None = None,
    ) -> Self: ...
    @staticmethod
    def from_toml(
        text: str,
        *,
        name: str = "the station",
        robots: int | None = None,
        belt_speed: float | None = None,
    ) -> Station:
        """The station of the text of a station file, which messages call ``name``."""

    @staticmethod
    def built_in() -> list[str]:
        """The names of the built-in stations, the default first."""

    def to_toml(self) -> str:
        """The station as the text of a station file; ``from_toml`` reads an equal one."""

    @property
    def hash(self) -> str:
        """The hash by which results name the station."""
    @property
    def robots(self) -> list[str]:
        """The names of the robots, upstream first."""
    @property
    def classes(self) -> list[str]:
        """The names of the classes of items."""
    @property
    def belt_speed(self) -> float:
        """Speed of the belt [m/s]."""
    @property
    def belt_length(self) -> float:
        """Length of the belt [m]."""
    @property
    def belt_width(self) -> float:
        """Width of the belt [m]."""
    def __hash__(self) -> int: ...

class Pattern:
    """The items of one run, furthest downstream first; it cannot be changed.

    Columns are arrays or lists of one dimension with a value for every item, in any order; in lists
    ``None`` is an unknown value.

    Args:
        x: Position along the travel at time 0 [m], at most 0.
        y: Position across the belt from its centre line [m].
        id: Unique names; "1", "2", ... if not given.
        area_cm2: Area seen from above [cm^2].
        p_detection: Probability that the detection is a real item.
        p_grasp: Probability that a grasp succeeds.
        weight: Explicit reward r, instead of the one computed from the three columns before.
        item_class: The class that the item is reported as.
        true_class: The class that the item is of.

    Raises:
        TypeError: A column that does not hold numbers, or texts.
        ValueError: Another shape, or a value that the model does not allow, such as NaN.
    """

    def __new__(
        cls,
        x: ArrayLike,
        y: ArrayLike,
        *,
        id: list[str] | None = None,
        area_cm2: ArrayLike | list[float | None] | None = None,
        p_detection: ArrayLike | list[float | None] | None = None,
        p_grasp: ArrayLike | list[float | None] | None = None,
        weight: ArrayLike | list[float | None] | None = None,
        item_class: list[str | None] | None = None,
        true_class: list[str | None] | None = None,
    ) -> Self: ...
    @staticmethod
    def from_frame(frame: Any) -> Pattern:
        """The pattern of a data frame of pandas or polars, with the columns of a pattern file: ``x`` and
        ``y``, and any of ``id``, ``area_cm2``, ``p_detection``, ``p_grasp``, ``weight``, ``class`` and
        ``true_class``. NaN and null are unknown values. Another column is a ``ValueError``.
        """

    @staticmethod
    def from_csv(path: str | os.PathLike[str]) -> Pattern:
        """Read a pattern file."""

    @staticmethod
    def from_csv_text(text: str, *, name: str = "the pattern") -> Pattern:
        """The pattern of the text of a pattern file, which messages call ``name``."""

    @staticmethod
    def grid(width: float | Station, spacing: float, items: int) -> Pattern:
        """A square lattice with this spacing [m] on a belt of this width [m]."""

    @staticmethod
    def poisson(width: float | Station, radius: float, items: int, *, seed: int = 1) -> Pattern:
        """Items at random, no two closer than ``radius`` [m], with no room for another."""

    @staticmethod
    def random(station: Station | str | os.PathLike[str], flow: float, items: int, *, seed: int = 1) -> Pattern:
        """A Poisson process of ``flow`` items per minute [1/min] on the belt of a station."""

    def to_csv(self) -> str:
        """The pattern as the text of a pattern file; ``from_csv_text`` reads an equal one."""

    @property
    def x(self) -> NDArray[np.float64]:
        """Positions along the travel at time 0 [m], [items]."""
    @property
    def y(self) -> NDArray[np.float64]:
        """Positions across the belt [m], [items]."""
    @property
    def reward(self) -> NDArray[np.float64]:
        """Rewards r, before the values of classes [items]."""
    @property
    def id(self) -> list[str]:
        """Names of the items."""
    @property
    def item_class(self) -> list[str | None]:
        """The classes that the items are reported as."""
    def __len__(self) -> int: ...

def patterns(
    source: str,
    station: Station | str | os.PathLike[str],
    *,
    items: int = 50,
    flow: float | None = None,
    cluster_size: float | None = None,
    cluster_spread: float | None = None,
    gap_length: float | None = None,
    gap_share: float | None = None,
    classes: str | None = None,
    seed: int = 1,
) -> list[Pattern]:
    """The patterns of a source, as after ``--patterns`` of the program.

    Args:
        source: ``grid:S``, ``poisson:R:N``, ``balanced:N``, ``FEED:F/min:N``, a file or a folder.
        station: The station for whose belt they are.
        items: Items per pattern.
        flow: Items per minute of a feed that does not say so [1/min].
        cluster_size: Mean number of items in a cluster of the feed ``clustered``; 5 if not given.
        cluster_spread: Standard deviation of their offset from its centre [m]; 0.1 if not given.
        gap_length: Mean length of an empty stretch of belt of the feed ``gaps`` [m]; 1 if not given.
        gap_share: Share of the belt in empty stretches; 0.3 if not given.
        classes: Classes and their shares, such as ``"pet:0.6,wood:0.4"``.
        seed: Seed of everything random.
    """

def trials(station: Station | str | os.PathLike[str], cases: str = "all") -> dict[str, list[Pattern]]:
    """The patterns on which trainings score a policy while it learns, as ``pickline train`` does, by the
    names of their cases.

    Args:
        station: The station for whose belt they are.
        cases: ``paper``, ``dense``, ``all`` or a TOML file, as for :func:`compare`.
    """

def learning_curves(curves: Sequence[tuple[str, ArrayLike, ArrayLike]]) -> str:
    """Draw learning curves of several trainings as an SVG file. Curves with the same name are drawn alike.

    Args:
        curves: The trainer's name, the numbers of decisions learned from, and the picking rates then as
            shares of greedy GT's, for each training.
    """

def simulate(
    station: Station,
    pattern: Pattern,
    strategy: Any,
    conditions: dict[str, Any],
    seed: int,
    bound: bool,
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> dict[str, Any]:
    """The parts of a :class:`pickline.Simulation`."""

class Report:
    """What a call found, in every form in which the program prints and writes it."""

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the work early."""
    def text(self) -> str:
        """The text that the program prints."""

    def csv(self) -> str:
        """The main table as CSV."""

    def json(self) -> str:
        """The whole report as JSON."""

    def page(self) -> str | None:
        """The page with tables and charts, or the replay of a run; None if there is none."""

    def tables(self) -> dict[str, dict[str, tuple[str, NDArray[Any] | list[str]]]]:
        """The columns of every CSV file of the report: by the file's name and the field, the name in the
        file and the values.
        """

def arrow_stream(columns: dict[str, NDArray[Any]]) -> Any:
    """A capsule with the table of these columns, for ``__arrow_c_stream__``. Its reader has the memory."""

def demonstrate(
    station: Station,
    patterns: Sequence[Pattern],
    strategy: Any,
    conditions: dict[str, Any],
    observation: str,
    slots: int,
    wait: bool,
    reward: tuple[float, float],
    seed: int,
    progress: Callable[[int, int, str], object] | None,
) -> tuple[str, list[dict[str, Any]]]:
    """The full name of a strategy, and its episode on each pattern."""

def compare(
    station: Station,
    cases: str | list[tuple[str, list[Pattern]]],
    *,
    strategy: list[Any],
    replicates: int,
    reference: str,
    robust: str | None,
    train_patterns: str | None,
    train_items: int | None,
    paper: bool,
    greedy: bool,
    policy: bool,
    bound: bool,
    tune: bool,
    area: str | None,
    p_detection: str | None,
    p_grasp: str | None,
    classes: str | None,
    seed: int,
    conditions: dict[str, Any],
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> Report:
    """The report of a :class:`pickline.Comparison`; ``call`` is how it says who made it."""

def sweep(
    station: Station,
    sweep: str,
    *,
    strategy: list[Any],
    patterns: str | list[Pattern],
    items: int | None,
    feed: dict[str, float | None],
    from_: float | None,
    to: float | None,
    step: float | None,
    purity: float | None,
    robust: str | None,
    train_patterns: str | None,
    train_items: int | None,
    greedy: bool,
    tune: bool,
    bound: bool,
    area: str | None,
    p_detection: str | None,
    p_grasp: str | None,
    classes: str | None,
    seed: int,
    conditions: dict[str, Any],
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> Report:
    """The report of a :class:`pickline.Sweep`; ``call`` is how it says who made it."""

def robots_down(
    station: Station,
    *,
    strategy: list[Any],
    patterns: str | list[Pattern],
    items: int | None,
    feed: dict[str, float | None],
    robust: str | None,
    train_patterns: str | None,
    train_items: int | None,
    greedy: bool,
    tune: bool,
    area: str | None,
    p_detection: str | None,
    p_grasp: str | None,
    classes: str | None,
    seed: int,
    conditions: dict[str, Any],
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> Report:
    """The report of a :class:`pickline.RobotsDown`; ``call`` is how it says who made it."""

def optimize(
    station: Station,
    *,
    strategy: list[Any],
    patterns: str | list[Pattern],
    items: int | None,
    feed: dict[str, float | None],
    objective: str,
    risk: str,
    search: str,
    starts: int,
    alpha: float,
    speed_step: float,
    max_runs: int | None,
    time_limit: float | None,
    validate: int | None,
    bound: bool,
    area: str | None,
    p_detection: str | None,
    p_grasp: str | None,
    classes: str | None,
    seed: int,
    conditions: dict[str, Any],
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> Report:
    """The report of a :class:`pickline.Optimum`; ``call`` is how it says who made it."""

def bound(
    station: Station,
    pattern: Pattern,
    *,
    weight: bool,
    slot: float | None,
    iterations: int,
    seed: int,
    conditions: dict[str, Any],
    progress: Callable[[int, int, str], object] | None,
    call: str,
) -> Report:
    """The report of a :class:`pickline.Bound`; ``call`` is how it says who made it."""

def check(
    station: Station,
    pattern: Pattern,
    picks: str | os.PathLike[str],
    *,
    tolerance: float,
    camera_x: float | None,
    update_hz: float,
    call: str,
) -> Report:
    """The report of a :class:`pickline.Verification` of a file of picks; ``call`` says who made it."""

def import_mot(
    file: str | os.PathLike[str],
    *,
    fps: float,
    scale: float,
    axis: str,
    belt_speed: float,
    form: str | None,
    boxes: str | None,
    image_size: tuple[float, float] | None,
    reverse: bool,
    angle: float,
    centre_px: float | None,
    min_frames: int,
    split_distance: float,
    merge_distance: float,
    class_names: str | None,
    accept_mismatch: bool,
) -> tuple[Pattern, str, list[str], list[str]]:
    """The parts of a :class:`pickline.Import`: the pattern, the report as JSON, what was read, dropped and
    measured in words, and warnings.
    """

def make_shard(words: list[str]) -> None:
    """Make one shard of a call, in a process that has other work too; raises what the program would print."""

def program(words: list[str]) -> int:
    """Run the program with these words, of which the first is its name; returns its exit code."""

class Batch:
    """The environments behind ``SortingEnv`` and ``SortingVectorEnv``."""

    def __new__(
        cls,
        station: Station,
        patterns: list[Pattern],
        conditions: dict[str, Any],
        observation: str,
        slots: int,
        wait: bool,
        reward: tuple[float, float],
        count: int,
    ) -> Self: ...
    @property
    def observation_size(self) -> int: ...
    def bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    @property
    def actions(self) -> int: ...
    def reseed(self, index: int, seed: int) -> None: ...
    def reset(
        self,
        observations: NDArray[np.float32],
        masks: NDArray[np.bool_],
        chosen: NDArray[np.bool_] | None = None,
    ) -> None: ...
    def step(self, actions: NDArray[np.int64], written: tuple[NDArray[Any], ...]) -> bool: ...
    def begin(self, observation: NDArray[np.float32], mask: NDArray[np.bool_]) -> None: ...
    def advance(
        self, action: int, observation: NDArray[np.float32], mask: NDArray[np.bool_]
    ) -> tuple[float, dict[str, Any] | None]: ...
    def picks(self, index: int) -> tuple[int, dict[str, NDArray[Any]]]: ...
    def due(self, index: int) -> tuple[int, float] | None: ...
    def items(self, index: int) -> list[int]: ...
