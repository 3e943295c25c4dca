"""Patterns from recordings."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from pickline import _pickline
from pickline._arguments import checked
from pickline._pickline import Pattern

__all__ = ["Import", "import_mot"]


@dataclass(frozen=True, eq=False)
class Import:
    """A pattern from a recording; ``print`` shows what was read, dropped and measured."""

    pattern: Pattern
    """One item for each object, with the id of its track."""
    report: dict[str, Any] = field(repr=False)
    """What was read, dropped, split, merged and measured, as in the program's JSON."""
    warnings: list[str]
    """What is doubtful about the recording or the values."""
    lines: list[str] = field(repr=False)
    """The report in words."""

    def __str__(self) -> str:
        warnings = [f"warning: {warning}" for warning in self.warnings]
        return "\n".join([*self.lines, *warnings])


@checked()
def import_mot(
    file: str | os.PathLike[str],
    *,
    fps: float,
    scale: float,
    axis: Literal["x", "y"],
    belt_speed: float,
    form: Literal["mot", "supervision", "ultralytics", "yolo", "coco"] | None = None,
    boxes: Literal["sizes", "corners", "centres"] | None = None,
    image_size: tuple[float, float] | None = None,
    reverse: bool = False,
    angle: float = 0.0,
    centre_px: float | None = None,
    min_frames: int = 2,
    split_distance: float = 0.1,
    merge_distance: float = 0.02,
    class_names: Mapping[int, str] | str | None = None,
    accept_mismatch: bool = False,
) -> Import:
    """Turn the output of a tracker or a detector into a pattern, as ``pickline pattern import`` does.

    Args:
        file: The recording: a file, or a folder of label files.
        fps: Frames per second of the recording [1/s].
        scale: Size of a pixel on the belt [m/px].
        axis: The image axis along which the belt travels.
        belt_speed: Speed of the belt during the recording [m/s].
        form: ``"mot"``, ``"supervision"``, ``"ultralytics"``, ``"yolo"`` or ``"coco"``; ``--as`` of the
            program. Detected from the content if not given.
        boxes: Meaning of the four numbers of a box in MOT and COCO files.
        image_size: Width and height of the image [px], for boxes given as shares of it.
        reverse: Whether the belt travels towards smaller pixel values.
        angle: Angle of the travel from the axis [degrees].
        centre_px: Pixel of the belt's centre line across the travel [px]; midway between the outermost
            items if not given.
        min_frames: Tracks seen in fewer frames are dropped.
        split_distance: A track that jumps further along the belt is split [m].
        merge_distance: Consecutive tracks that agree this closely are one object [m].
        class_names: Names of the class ids, as a mapping or a text such as ``"1:pet,2:hdpe"``.
        accept_mismatch: Make the pattern even if the tracks contradict these values.

    Raises:
        ValueError: A value, or a recording that cannot be read or contradicts the values.
        OSError: A file that cannot be read.
    """
    if image_size is not None:
        try:
            width, height = (float(length) for length in image_size)
        except (TypeError, ValueError):
            raise TypeError(
                f"image_size: {image_size!r} is not two numbers\n"
                "  cure: give width and height [px], such as (1920, 1080)"
            ) from None
        image_size = width, height
    if isinstance(class_names, Mapping):
        class_names = ",".join(f"{number}:{name}" for number, name in class_names.items())
    pattern, report, lines, warnings = _pickline.import_mot(
        file,
        fps=fps,
        scale=scale,
        axis=axis,
        belt_speed=belt_speed,
        form=form,
        boxes=boxes,
        image_size=image_size,
        reverse=reverse,
        angle=angle,
        centre_px=centre_px,
        min_frames=min_frames,
        split_distance=split_distance,
        merge_distance=merge_distance,
        class_names=class_names,
        accept_mismatch=accept_mismatch,
    )
    return Import(pattern, json.loads(report), warnings, lines)
