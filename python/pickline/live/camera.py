"""Cameras: they report where items are."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from .checks import shown
from .errors import BadMessage, Overflow
from .messages import Detection, FromNode, Role, SourceKind, Status, Tick, ToNode
from .peer import Peer

__all__ = ["Camera", "Item"]

Item = Detection | Mapping[str, Any] | Sequence[float]
"""An item in a picture: the fields of a detection without its `stamp`, `(x, y)` [m], or a
`Detection`, whose timestamp is replaced by that of the picture."""

OLDEST = 55.0
"""The node refuses timestamps that are a minute old [s]; some of it is needed for the way."""

MARGIN = 1.0
"""The node has read what was written this long [s] before the last message that it says it has
heard: longer than a message is on its way, or waits for the node's journal."""

MOST_WAITING = 10_000
"""Detections that wait for a node which takes none, before `report` refuses more."""

MOST_KEPT = 100_000
"""Detections that are kept to be sent again. The node knows no more items than this."""

FIELDS = {"class" if one.name == "class_" else one.name for one in fields(Detection)} | {"class_"}


@dataclass
class _Picture:
    """A picture that may have to be sent again.

    Attributes:
        detections: What it shows.
        written: When it was handed to the present connection, by the steady clock [s]; none if it
            was not.
        was_written: Whether it was ever handed to a connection.
    """

    detections: tuple[Detection, ...]
    written: float | None = None
    was_written: bool = False


class Camera(Peer):
    """A camera of a line.

        async with Camera("127.0.0.1:7400", "north") as camera:
            await camera.report([{"x": 0.12, "y": -0.05, "id": "17", "class": "PET"}], stamp)

    After a lost connection it sends the pictures again that the node may not have received, as far
    as they are not older than `keep`. The node takes a repeated detection for the same item.
    Pictures that are older when the connection is back are lost, which is logged and counted in
    `dropped`.

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
        self._kept: deque[_Picture] = deque()
        self._count = 0
        # Those that wait for the present connection.
        self._unwritten: deque[_Picture] = deque()

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
        try:
            several = tuple(items)
        except TypeError:
            problem = f"`{shown(items)}` is not a list of items"
            raise BadMessage("a picture", problem, "give dicts, or (x, y) [m] of each item") from None
        picture = tuple(self._detection(item, stamp) for item in several)
        if picture:
            self._check_room(len(picture), MOST_WAITING)
            self._forget()
            if self._count + len(picture) > MOST_KEPT:
                problem = f"{self._count} detections are kept for the next connection"
                raise Overflow(self._place, problem, "give a smaller `keep`")
            kept = _Picture(picture)
            self._kept.append(kept)
            self._count += len(picture)
            if self._is_up:
                self._unwritten.append(kept)
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
            values["source"] = values.get("source") or self.name
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
        while self._kept and self._kept[0].detections[0].stamp < oldest:
            first = self._kept[0]
            if self._is_up and first.written is None:
                # It waits in the queue, which is bounded.
                return
            if not first.was_written:
                self._drop(len(first.detections))
            self._remove_first()

    def _remove_first(self) -> None:
        self._count -= len(self._kept.popleft().detections)

    def _drop(self, count: int) -> None:
        if not self.dropped:
            self._warn(
                f"{self._place}: pictures of more than {self.keep:g} s without a connection are lost"
            )
        self.dropped += count

    def _greeting(self) -> list[ToNode]:
        self._forget()
        for picture in self._kept:
            picture.written = None
        self._unwritten = deque(self._kept)
        return [detection for picture in self._kept for detection in picture.detections]

    def _sent(self, messages: list[ToNode]) -> None:
        now = time.monotonic()
        for message in messages:
            if self._unwritten and message is self._unwritten[0].detections[-1]:
                picture = self._unwritten.popleft()
                picture.written, picture.was_written = now, True

    def _hear(self, message: FromNode) -> None:
        if not isinstance(message, Status):
            return
        for source in message.sources:
            if source.name == self.name and source.kind == SourceKind.CAMERA:
                read = time.monotonic() - source.age - MARGIN
                while self._kept and (written := self._kept[0].written) is not None and written < read:
                    self._remove_first()
