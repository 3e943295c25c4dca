#!/usr/bin/env python3
"""The controller of a robot, as a client of `pickline run`; see camera.py.

    python examples/robot.py 127.0.0.1:7400 r1

The arm is simulated. With hardware, replace `SimulatedArm` by what moves yours.
"""

import argparse
import asyncio
import random
from pathlib import Path

from pickline.live import LineError, Robot, Verdict, Work


class SimulatedArm:
    """An arm that is always in time, and whose grasps sometimes fail."""

    def __init__(self, failing: float, seed: int) -> None:
        self.failing, self.rng = failing, random.Random(seed)

    async def pick(self, work: Work) -> Verdict:
        """Waits at the bin, meets the item, and brings it to the bin. `until` follows the node's
        changes of the task, and leaves this function when the node wants it dropped."""
        await work.until("start")
        await work.until("meet_at")
        has_item = self.rng.random() >= self.failing
        # From here on the item is in the gripper: it is brought to the bin in any case.
        await asyncio.sleep(max(0.0, work.task.free_at - work.task.meet_at))
        return Verdict.PICKED if has_item else Verdict.GRASP_FAIL


async def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("address", help="HOST:PORT, tls://HOST:PORT or mqtt://HOST of the line")
    parser.add_argument("robot", help="the robot's name in the node's station file")
    parser.add_argument("--token", type=Path, help="file with the node's token")
    parser.add_argument("--failing", type=float, default=0.05, help="share of grasps that fail")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()

    arm = SimulatedArm(args.failing, args.seed)

    async def handle(work: Work) -> Verdict:
        task = work.task
        print(f"task {task.id}: item {task.item} at ({task.meet.x:.3f}, {task.meet.y:.3f}) m")
        return await arm.pick(work)

    async with Robot(args.address, args.robot, token=args.token) as robot:
        await robot.run(handle)


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except LineError as error:
        raise SystemExit(f"robot.py: {error}") from None
    except KeyboardInterrupt:
        raise SystemExit(130) from None
