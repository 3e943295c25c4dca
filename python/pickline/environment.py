"""The line as a Gymnasium environment."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable
from typing import Any, Literal, Unpack

import gymnasium
import numpy as np
from gymnasium import error
from numpy.typing import NDArray

from pickline._arguments import checked
from pickline._parts import (
    PAPER_REWARD,
    ObservationName,
    SlotSpace,
    Uncopied,
    make_batch,
    observation_space,
    rust_seed,
)
from pickline._pickline import Pattern, Station
from pickline.conditions import Conditions
from pickline.rendering import FPS, LinePainter
from pickline.simulation import Picks

__all__ = ["SortingEnv"]


class SortingEnv(Uncopied, gymnasium.Env[NDArray[np.float32], np.int64]):
    """Robots along a moving belt pick items; every step is one decision of one robot.

    ## Description

    Items lie on a belt that carries them past robots. Whenever a robot is free and can reach
    something, it decides which item it picks next. Time jumps from decision to decision; robots with
    nothing to choose from are skipped. An episode is one pattern, drawn at random from ``patterns``.
    The process is the one of Jermann et al. and runs in Rust.

    ## Action space

    ``Discrete(slots)``, or ``Discrete(slots + 1)`` with ``wait=True``:

    ========= ============================================================================
    action    meaning
    ========= ============================================================================
    0 .. K-1  pick the item in this slot
    K         only with ``wait``: do nothing for a quarter of the time [s] that the arm
              needs for its reach
    ========= ============================================================================

    Slots are filled from the first. Which actions are allowed is in ``info["action_mask"]`` (int8
    [actions], as ``Discrete.sample`` takes it) and ``action_masks()`` (bool [actions], as MaskablePPO
    asks for it). A masked action is a ``ValueError`` and changes nothing. Without a mask,
    ``action_space.sample()`` draws among the allowed actions.

    ## Observation space

    ``Box(low, high, (n,), float32)``: the globals, then the slots, each with the same features. Empty
    slots are zero. All features are scaled to the order of 1; the tables are in
    ``src/decision/observation/`` of the repository.

    The bounds are finite and hold on every pattern. They follow from the station, and from ``camera_x``,
    so that environments of one station have the same space, whatever their patterns are. The bound of a
    reward is the highest value of a class, at least 1, or the highest ``weight`` in ``patterns`` if that
    is more: the model has no smaller one. That of a number of items is the number that the largest
    pattern can have.

    =============== ======= ================= ==========================================
    ``observation`` globals features per slot what it is
    =============== ======= ================= ==========================================
    ``"full"``      21      17                relative to the deciding robot, with what
                                              the other robots could do with each item
    ``"paper"``     12      4                 the paper's: x, y, processing time and
                                              reward; busy and time until free of robots
    ``"real"``      see     see               ``full``, and what only real lines have:
                    source  source            probabilities, bins, arms that accelerate
    =============== ======= ================= ==========================================

    ## Reward

    ``reward[0] * r`` for every successful pick of an item of reward r, and ``reward[1] * 60 sum(r) / T``
    at the end of the episode, which lasts T [s]. Both weights are 1 in the paper.

    ## Starting state

    The belt brings the first item; the state is that of the first decision.

    ## Episode end

    The episode terminates when all items are picked or the last one has left the belt. Nobody decides
    then, so the last observation is zero and its mask allows nothing. The environment never truncates.

    ## Information

    ``action_mask`` at every step. At the end also the figures of the episode: ``items`` and ``picked``,
    ``weight`` (sum of r), ``end`` (T [s]), ``picking_rate`` and ``weighted_rate`` [1/min].

    ## Seeds

    ``reset(seed=s)`` begins the episodes that the Rust environment with seed s and index 0 has:
    the same actions give the same observations and picks, to the bit, on every machine.

    ## Version history

    * v0: initial version

    Args:
        station: A :class:`pickline.Station`, the name of a built-in one, or a station file.
        patterns: One pattern, several, or a source as after ``--patterns`` of the program, such as
            ``"grid:0.15"``, ``"poisson:0.12:100"`` or ``"balanced:20"``.
        items: Items per pattern of a source.
        pattern_seed: Seed of the patterns of a source.
        observation: ``"full"``, ``"paper"`` or ``"real"``.
        slots: Number of slots K, 1 to 256; 10 for ``"paper"`` and 16 otherwise if not given.
        wait: Whether waiting is an action.
        reward: The two weights of the reward.
        render_mode: ``"rgb_array"`` for pictures, ``"human"`` for a window; both need pygame
            (``pip install pygame-ce``).
        **under: The conditions of every episode; see :class:`pickline.Conditions`.

    Raises:
        ValueError: A value that the model does not allow, or patterns that do not fit the station.
        OSError: A file that cannot be read.
        ImportError: A render mode without pygame.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": FPS}

    @checked(Conditions)
    def __init__(
        self,
        station: Station | str | os.PathLike[str] = "paper",
        patterns: Pattern | Iterable[Pattern] | str = "poisson:0.12:100",
        *,
        items: int = 50,
        pattern_seed: int = 1,
        observation: ObservationName = "full",
        slots: int | None = None,
        wait: bool = False,
        reward: tuple[float, float] = PAPER_REWARD,
        render_mode: Literal["rgb_array", "human"] | None = None,
        **under: Unpack[Conditions],
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            known = " or ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode: {render_mode!r} is not available\n  cure: give {known}")
        self.render_mode = render_mode
        self.station, self.patterns, self._batch = make_batch(
            station,
            patterns,
            count=1,
            items=items,
            pattern_seed=pattern_seed,
            observation=observation,
            slots=slots,
            wait=wait,
            reward=reward,
            under=under,
        )
        self._mask = np.zeros(self._batch.actions, np.bool_)
        self._painter = None
        if render_mode is not None:
            self._painter = LinePainter(self.station, in_window=render_mode == "human")
        self._open = True
        self._begun = False
        self._running = False
        self._seeded = False
        self.observation_space = observation_space(self._batch)
        self.action_space = SlotSpace(self._mask)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode on a pattern drawn at random."""
        self._check_open("reset")
        if options is not None and not isinstance(options, dict):
            raise TypeError(f"options: {options!r} is not a dict\n  cure: give none")
        if options:
            raise ValueError(f"options: unknown option {min(options, key=str)!r}\n  cure: give none")
        super().reset(seed=seed)
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**63))
        if seed is not None:
            self._batch.reseed(0, rust_seed(seed))
            self._seeded = True
        observation = np.zeros(self._batch.observation_size, np.float32)
        self._batch.begin(observation, self._mask)
        self._begun = self._running = True
        if self.render_mode == "human":
            self._picture()
        return observation, self._info()

    def step(
        self, action: int | np.integer[Any]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Take one decision."""
        self._check_open("step")
        if not self._running:
            state = "the episode is over" if self._begun else "no episode has begun"
            raise error.ResetNeeded(f"step: {state}\n  cure: call reset before the first step of one")
        try:
            if isinstance(action, bool | np.bool_):
                raise TypeError
            index = operator.index(action)
        except TypeError:
            raise TypeError(
                f"action: {action!r} is not an integer\n  cure: give the index of a slot"
            ) from None
        if not 0 <= index < len(self._mask):
            raise ValueError(
                f"action: {index} is out of range\n  cure: give 0 to {len(self._mask) - 1}"
            )
        observation = np.zeros(self._batch.observation_size, np.float32)
        reward, figures = self._batch.advance(index, observation, self._mask)
        info = self._info()
        if figures is not None:
            self._running = False
            info.update(figures)
        if self.render_mode == "human":
            self._picture()
        return observation, reward, figures is not None, False, info

    def render(self) -> NDArray[np.uint8] | None:
        """The line at the moment of the decision, uint8 [height, width, 3]; None if the render mode is
        not ``"rgb_array"``."""
        self._check_begun("render")
        return self._picture() if self.render_mode == "rgb_array" else None

    def _picture(self) -> NDArray[np.uint8] | None:
        if self._painter is None:
            return None
        picks, robot, time = self.picks, self.robot, self.time
        if time is None:
            # Nobody decides any more: when the last item is in its bin.
            time = float(picks.release.max(initial=0.0))
        return self._painter.paint(self.pattern, picks, time, robot)

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions are allowed now, bool [actions]."""
        self._check_begun("action_masks")
        return self._mask.copy()

    @property
    def robot(self) -> int | None:
        """Index of the robot that decides, upstream first; None if nobody does."""
        due = self._due()
        return None if due is None else due[0]

    @property
    def time(self) -> float | None:
        """Time of the decision [s]; None if nobody decides."""
        due = self._due()
        return None if due is None else due[1]

    @property
    def slot_items(self) -> NDArray[np.int64]:
        """The item in each filled slot, as its index in the pattern [filled slots]."""
        self._check_begun("slot_items")
        return np.array(self._batch.items(0), np.int64)

    @property
    def pattern(self) -> Pattern:
        """The pattern of the episode."""
        self._check_begun("pattern")
        return self.patterns[self._batch.picks(0)[0]]

    @property
    def picks(self) -> Picks:
        """The picks of the episode so far."""
        self._check_begun("picks")
        return Picks(**self._batch.picks(0)[1])

    def close(self) -> None:
        """End the environment; no other method may be called after it."""
        self._open = False
        if self._painter is not None:
            self._painter.close()

    def _due(self) -> tuple[int, float] | None:
        self._check_open("robot, time")
        return self._batch.due(0)

    def _info(self) -> dict[str, Any]:
        return {"action_mask": self._mask.astype(np.int8)}

    def _check_begun(self, what: str) -> None:
        self._check_open(what)
        if not self._begun:
            raise error.ResetNeeded(f"{what}: no episode has begun\n  cure: call reset before it")

    def _check_open(self, what: str) -> None:
        if not self._open:
            raise error.ClosedEnvironmentError(
                f"{what}: the environment is closed\n  cure: make a new one"
            )
