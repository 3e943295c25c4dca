"""The examples: a camera and robots work together on a simulated belt."""

from __future__ import annotations

import asyncio
import re
import signal
import sys
from pathlib import Path

from live_support import needs_program, node, run

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"

# The examples run in processes of their own, which have to find the package in the same way.
START = """
import sys
sys.path.insert(0, sys.argv.pop(1))
import live_support, runpy
sys.argv.pop(0)
runpy.run_path(sys.argv[0], run_name="__main__")
"""


async def start(name: str, *arguments: str) -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-u", "-c", START, str(Path(__file__).parent), str(EXAMPLES / name)),
        *arguments,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )


@needs_program
def test_camera_and_robots() -> None:
    async def play() -> None:
        async with node("--status-every", "0.2") as line:
            robots = [await start("robot.py", line.address, name) for name in ("r1", "r2")]
            camera = await start("camera.py", line.address, "--speed", "0.6", "--items", "10")
            out, err = await camera.communicate()
            assert camera.returncode == 0, err.decode()
            last = out.decode().splitlines()[-1]
            picked, seen, left = map(int, re.findall(r"\d+", last))
            assert (seen, left) == (10, 0) and picked > 0
            tasks = 0
            for robot in robots:
                robot.send_signal(signal.SIGINT)
                out, err = await robot.communicate()
                assert robot.returncode == 130, err.decode()
                tasks += out.decode().count("task")
            assert tasks >= picked

    run(play())


@needs_program
def test_what_is_wrong_is_told_in_one_line() -> None:
    async def play() -> None:
        async with node() as line:
            robot = await start("robot.py", line.address, "r9")
            _, err = await robot.communicate()
            assert robot.returncode == 1
            assert err.decode().startswith("robot.py: ") and "no robot `r9`" in err.decode()
            assert err.decode().count("\n") == 1

    run(play())
