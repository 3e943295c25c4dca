"""Cameras: they report where items are."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, ClassVar, Union

from .errors import BadMessage, Overflow
from .messages import Detection, Role, Tick, ToNode
from .peer import Peer, log

__all__ = ["Camera", "Item"]

Item = Union[Detection, Mapping[str, Any], Sequence[float]]
"""An item in a picture: the fields of a detection without its `stamp`, `(x, y)` [m], or a
`Detection`, whose timestamp is replaced by that of the picture."""

OLDEST = 55.0
"""The node refuses timestamps that are a minute old [s]; some of it is needed for the way."""

MOST_WAITING = 10_000
"""Detections that wait for a node which takes none, before `report` refuses more."""

MOST_KEPT = 100_000
"""Detections that are kept to be sent again. The node knows no more items than this."""

FIELDS = {"class" if one.name == "class_" else one.name for one in fields(Detection)} | {"class_"}


class Camera(Peer):
    """A camera of a line.

        async with Camera("127.0.0.1:7400", "north") as camera:
            await camera.report([{"x": 0.12, "y": -0.05, "id": "17", "class": "PET"}], stamp)

    After a lost connection it sends the pictures of the last `keep` seconds again, because the node
    may not have received them. The node takes a repeated detection for the same item. Pictures that
    are older when the connection is back are lost, which is logged and counted in `dropped`.

    Args:
        address: As for `Peer`, as are the options.
        name: The camera's name. Each camera of a line needs its own.
        keep: How long pictures are kept [s], 0 to 55.
    """

    role: ClassVar[Role] = Role.CAMERA

    def __init__(
        self, address: str, name: str = "camera", *, keep: float = 10.0, **options: Any
    ) -> None:
        super().__init__(address, name, **options)
        if not 0 <= keep <= OLDEST:
            raise BadMessage("`keep`", f"{keep} is out of range", f"give 0 to {OLDEST:g} s")
        self.keep = float(keep)
        self.dropped = 0
        """Detections that were never sent, because there was no connection for too long."""
        self._kept: deque[tuple[Detection, ...]] = deque()
        self._count = 0
        # How many pictures at the end of `_kept` were never handed to a connection.
        self._unsent = 0

    async def report(self, items: Iterable[Item], stamp: float | None = None) -> None:
        """Reports one picture: all items that were seen at the same time. It is sent in one piece,
        so that the node can match it as a whole.

        Args:
            items: The items. An empty picture sends nothing.
            stamp: When the picture was taken [s]: in the middle of the exposure, not when it was
                evaluated. By default now.

        Raises:
            BadMessage: The node would refuse a value. Nothing of the picture is sent.
            Overflow: The node takes nothing. Nothing of the picture is sent.
            Refused: The node does not let this camera in any more.
        """
        self._check_open()
        stamp = self.clock() if stamp is None else stamp
        picture = tuple(self._detection(item, stamp) for item in items)
        if picture:
            self._check_room(len(picture), MOST_WAITING)
            self._forget()
            if self._count + len(picture) > MOST_KEPT:
                problem = f"{self._count} detections are kept for the next connection"
                raise Overflow(self._place, problem, "give a smaller `keep`")
            self._kept.append(picture)
            self._count += len(picture)
            self._unsent += 1
            self._push(*picture)
        # A program that reports without a pause must let the connection work.
        await asyncio.sleep(0)

    async def tick(self, stamp: float) -> None:
        """Tells a node with `--clock messages` that time has come this far."""
        self._check_open()
        self._push(Tick(stamp))
        await asyncio.sleep(0)

    def _detection(self, item: Item, stamp: float) -> Detection:
        if isinstance(item, Detection):
            return replace(item, stamp=stamp, source=item.source or self.name)
        if isinstance(item, Mapping):
            values = dict(item)
            unknown = [str(name) for name in values if name not in FIELDS or name == "stamp"]
            if unknown:
                known = ", ".join(sorted(FIELDS - {"stamp", "class_"}))
                problem = f"`{unknown[0]}` is not a field of an item"
                raise BadMessage("a detection", problem, f"give some of {known}")
            if "class" in values:
                values["class_"] = values.pop("class")
            if values.get("x") is None or values.get("y") is None:
                raise BadMessage("a detection", "`x` or `y` is missing", "give both [m]")
            values.setdefault("source", self.name)
            return Detection(stamp=stamp, **values)
        try:
            x, y = item
        except (TypeError, ValueError):
            problem = f"{item!r} is not an item"
            raise BadMessage("a detection", problem, "give a dict of its fields, or (x, y) [m]") from None
        return Detection(stamp=stamp, x=x, y=y, source=self.name)

    def _forget(self) -> None:
        """Drops pictures that are too old to be sent again."""
        oldest = self.clock() - self.keep
        while self._kept and self._kept[0][0].stamp < oldest:
            if self._unsent >= len(self._kept):
                if self._is_up:
                    # It waits in the queue, which is bounded.
                    return
                self._unsent -= 1
                self._drop(len(self._kept[0]))
            self._count -= len(self._kept.popleft())

    def _drop(self, count: int) -> None:
        if not self.dropped:
            log.warning(
                "%s: pictures of more than %g s without a connection are lost", self._place, self.keep
            )
        self.dropped += count

    def _greeting(self) -> list[ToNode]:
        self._forget()
        return [detection for picture in self._kept for detection in picture]

    def _sent(self, messages: list[ToNode]) -> None:
        if not self._outbox:
            self._unsent = 0
