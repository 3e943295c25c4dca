#!/usr/bin/env python3
"""A camera and the encoder of the belt below it, as clients of `pickline run`.

Without hardware, the belt and its items are simulated. In three terminals:

    pickline run --listen 127.0.0.1:7400
    python examples/robot.py 127.0.0.1:7400 r1
    python examples/camera.py 127.0.0.1:7400 --items 20

With hardware, replace `SimulatedBelt` by what asks your camera and your encoder.
"""

import argparse
import asyncio
import random
import time
from pathlib import Path

from pickline.live import Belt, Camera, LineError


class SimulatedBelt:
    """A belt at constant speed, with items 0.3 m apart."""

    def __init__(self, speed: float, items: int, seed: int) -> None:
        rng = random.Random(seed)
        self.speed, self.began = speed, time.time()
        self.items = [(f"i{n}", -0.3 * n, rng.uniform(-0.2, 0.2)) for n in range(items)]

    def encoder(self) -> tuple[float, float]:
        """Speed [m/s] and travel [m]."""
        return self.speed, self.speed * (time.time() - self.began)

    def picture(self, stamp: float) -> list[dict]:
        """The items below the camera, which sees the first half metre of the belt."""
        travel = self.speed * (stamp - self.began)
        return [
            {"id": name, "x": x + travel, "y": y, "class": "PET", "p_grasp": 0.95}
            for name, x, y in self.items
            if 0.0 <= x + travel <= 0.5
        ]

    def is_empty(self) -> bool:
        return self.items[-1][1] + self.encoder()[1] > 0.5


async def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("address", help="HOST:PORT, tls://HOST:PORT or mqtt://HOST of the line")
    parser.add_argument("--name", default="north", help="name of the camera")
    parser.add_argument("--token", type=Path, help="file with the node's token")
    parser.add_argument("--speed", type=float, default=0.2, help="speed of the belt [m/s]")
    parser.add_argument("--items", type=int, default=20, help="number of items")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()

    world = SimulatedBelt(args.speed, args.items, args.seed)
    async with (
        Belt(args.address, "encoder", token=args.token) as belt,
        Camera(args.address, args.name, token=args.token) as camera,
        asyncio.TaskGroup() as group,
    ):
        following = group.create_task(belt.follow(world.encoder, every=0.02))
        while not world.is_empty():
            # The time of the exposure, not that at which the picture was evaluated.
            stamp = time.time()
            await camera.report(world.picture(stamp), stamp)
            await asyncio.sleep(0.1)
        # The belt has to be heard as long as robots work on it.
        async for status in camera.statuses():
            print(f"{status.picked} of {status.seen} picked, {status.on_belt + status.claimed} on the belt")
            if status.seen >= args.items and status.on_belt + status.claimed == 0:
                break
        following.cancel()


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except* LineError as error:
        raise SystemExit(f"camera.py: {error.exceptions[0]}") from None
    except* KeyboardInterrupt:
        raise SystemExit(130) from None
