"""Pictures of a line at one moment, for the render modes of the environments.

Needs pygame: ``pip install pygame-ce``.
"""

from __future__ import annotations

import colorsys
import tomllib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickline._pickline import Pattern, Station
from pickline.simulation import Picks

__all__ = ["FPS", "LinePainter"]

WIDTH = 960
"""Width of a picture [pixels]."""
MARGIN = 0.25
"""Space around the line [m]."""
SHORTEST = 200
"""Least height of a picture [pixels]."""
FPS = 15
"""Pictures per second in a window."""

PAPER, BELT, EDGE, ITEM, TEXT = "#ffffff", "#e6e9ee", "#8a919c", "#5b6470", "#20242a"


def _pygame() -> Any:
    try:
        import pygame
    except ImportError as error:
        raise ImportError(
            "render_mode: pictures need pygame\n  cure: pip install pygame-ce"
        ) from error
    return pygame


class LinePainter:
    """Draws a station seen from above, with the belt running to the right.

    Args:
        station: The station.
        in_window: Whether the pictures are shown in a window, too.
    """

    def __init__(self, station: Station, in_window: bool = False) -> None:
        pygame = _pygame()
        told = tomllib.loads(station.to_toml())
        self._belt: dict[str, float] = told["belt"]
        self._robots: list[dict[str, Any]] = told["robot"]
        for robot in self._robots:
            bins = robot["bin"]
            # One position, or tables of several bins.
            robot["bin"] = [bins] if not isinstance(bins[0], dict) else [bin["at"] for bin in bins]
        points = [robot["base"] for robot in self._robots]
        points += [place for robot in self._robots for place in robot["bin"]]
        half = self._belt["width"] / 2
        xs = [x for x, _ in points] + [0.0, self._belt["length"]]
        ys = [y for _, y in points] + [-half, half]
        self._left, self._top = min(xs) - MARGIN, max(ys) + MARGIN
        self._scale = WIDTH / (max(xs) + MARGIN - self._left)
        height = max(SHORTEST, round(self._scale * (self._top - min(ys) + MARGIN)))
        pygame.font.init()
        self._font = pygame.font.Font(None, 20)
        self._surface = pygame.Surface((WIDTH, height))
        self._window: Any = None
        if in_window:
            pygame.display.init()
            pygame.display.set_caption("pickline")
            self._window = pygame.display.set_mode((WIDTH, height))
            self._clock = pygame.time.Clock()

    def paint(
        self, pattern: Pattern, picks: Picks, time: float, deciding: int | None
    ) -> NDArray[np.uint8]:
        """The line at a moment, uint8 [height, width, 3].

        Args:
            pattern: The items.
            picks: The picks so far.
            time: The moment [s].
            deciding: Index of the robot that decides; None if nobody does.
        """
        pygame = _pygame()
        surface, half = self._surface, self._belt["width"] / 2
        surface.fill(PAPER)
        corner = self._at(0.0, half)
        size = (self._scale * self._belt["length"], self._scale * self._belt["width"])
        pygame.draw.rect(surface, BELT, (*corner, *size))
        pygame.draw.rect(surface, EDGE, (*corner, *size), 1)
        for index, robot in enumerate(self._robots):
            reach = self._scale * robot["reach"]
            pygame.draw.circle(surface, self._colour(index), self._at(*robot["base"]), reach, 1)
        # An item that is being fetched lies there until its grasp; after that the robot has it.
        taken = {int(item): int(robot) for item, robot in zip(picks.item, picks.robot, strict=True)}
        lifted = {int(item) for item, grasp in zip(picks.item, picks.grasp, strict=True) if grasp <= time}
        for item, (x0, y) in enumerate(zip(pattern.x, pattern.y, strict=True)):
            x = x0 + self._belt["speed"] * time
            if 0.0 <= x <= self._belt["length"] and item not in lifted:
                colour = self._colour(taken[item]) if item in taken else ITEM
                pygame.draw.circle(surface, colour, self._at(x, y), 4)
        for index, robot in enumerate(self._robots):
            self._paint_robot(index, robot, picks, time, index == deciding)
        told = f"{time:.1f} s   {len(lifted)} picked"
        surface.blit(self._font.render(told, True, TEXT), (8, 8))
        if self._window is not None:
            pygame.event.pump()
            self._window.blit(surface, (0, 0))
            pygame.display.flip()
            self._clock.tick(FPS)
        return np.transpose(pygame.surfarray.array3d(surface), (1, 0, 2))

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            _pygame().display.quit()
            self._window = None

    def _paint_robot(
        self, index: int, robot: dict[str, Any], picks: Picks, time: float, decides: bool
    ) -> None:
        pygame = _pygame()
        surface, colour = self._surface, self._colour(index)
        base = self._at(*robot["base"])
        for place in robot["bin"]:
            x, y = self._at(*place)
            pygame.draw.rect(surface, colour, (x - 7, y - 5, 14, 10), 2)
        hand, carries = self._hand(index, robot, picks, time)
        pygame.draw.line(surface, colour, base, self._at(*hand), 4)
        pygame.draw.circle(surface, colour, base, 8)
        if decides:
            pygame.draw.circle(surface, TEXT, base, 11, 2)
        if carries:
            pygame.draw.circle(surface, ITEM, self._at(*hand), 4)

    def _hand(
        self, index: int, robot: dict[str, Any], picks: Picks, time: float
    ) -> tuple[tuple[float, float], bool]:
        """Where the hand is [m], as if it moved uniformly on each way, and whether it carries an item."""
        place = tuple(robot.get("rest", robot["bin"][0]))
        for pick in np.flatnonzero((picks.robot == index) & (picks.decide <= time)):
            meet = (picks.x[pick], picks.y[pick])
            there = robot["bin"][picks.bin[pick]]
            begin, grasp, end = picks.decide[pick], picks.grasp[pick], picks.release[pick]
            if time < grasp:
                return _between(place, meet, (time - begin) / (grasp - begin)), False
            if time < end:
                return _between(meet, there, (time - grasp) / (end - grasp)), True
            place = tuple(there)
        return place, False

    def _at(self, x: float, y: float) -> tuple[float, float]:
        return self._scale * (x - self._left), self._scale * (self._top - y)

    def _colour(self, robot: int) -> tuple[int, ...]:
        hue = robot / max(1, len(self._robots))
        return tuple(round(255 * part) for part in colorsys.hsv_to_rgb(0.58 + hue, 0.75, 0.75))


def _between(start: Any, end: Any, share: float) -> tuple[float, float]:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])
