"""Writes tracker.txt: what a multi-object tracker prints of a belt, in the MOTChallenge
format, from a made-up scene. Seeded, so that it prints the same file again:

    python3 patterns/tracker.py > patterns/tracker.txt

A camera looks down on 0.8 m of a belt of 0.4 m that runs at 0.078 m/s along the image's
x axis, at 10 frames/s and 0.0015 m per pixel. It has the faults of real trackers: noise
on boxes and confidences, missed frames, an item that gets a new id half way, ids of
false detections that live one frame, a stain on the belt that stands still, a point
track without a box, a last line that was cut off.
"""

import random

FPS, SCALE, SPEED = 10, 0.0015, 0.078
VIEW, WIDTH = 0.8, 0.4
ITEMS = 30

random.seed(7)


def line(frame, track, x, y, size, confidence):
    """One box around the point (x, y) [m], size [m] wide and high."""
    if size is None:
        return f"{frame},{track},{x / SCALE:.1f},{y / SCALE:.1f},-1,-1,{confidence:.2f},-1,-1,-1"
    left, top, side = (x - size / 2) / SCALE, (y - size / 2) / SCALE, size / SCALE
    return f"{frame},{track},{left:.1f},{top:.1f},{side:.1f},{side:.1f},{confidence:.2f},-1,-1,-1"


def main():
    items, x = [], 0.0
    for _ in range(ITEMS):
        x -= random.uniform(0.04, 0.25)
        y = random.uniform(0.03, WIDTH - 0.03)
        items.append((x, y, random.uniform(0.03, 0.09), random.uniform(0.6, 0.95)))
    lines = []
    last = int((VIEW - x) / SPEED * FPS)
    for frame in range(1, last + 1):
        time = (frame - 1) / FPS
        for i, (x0, y, size, confidence) in enumerate(items):
            at = x0 + SPEED * time
            if not 0 <= at <= VIEW or random.random() < 0.08:
                continue
            track = 100 + i if i == 4 and at > 0.4 else i + 1
            shown = None if i == 9 else size * random.gauss(1, 0.03)
            noise = random.gauss(0, 0.001), random.gauss(0, 0.001)
            sure = min(1.0, max(0.0, random.gauss(confidence, 0.05)))
            lines.append(line(frame, track, at + noise[0], y + noise[1], shown, sure))
        if frame % 97 == 0:
            lines.append(line(frame, 200 + frame, 0.3, 0.2, 0.05, 0.31))
        if frame > 50 and frame % 3:
            lines.append(line(frame, 99, 0.62 + random.gauss(0, 0.0005), 0.35, 0.04, 0.5))
    print("\n".join(lines))
    print(f"{last + 1},{ITEMS},512.", end="")


main()
