"""Times `pickline optimize` on larger and larger inputs, for docs/scale.md.

    bash results/scaling/run.sh

Each point is a process of its own: its time is the shortest of up to three runs, its memory the largest resident
set. The slope of a curve is that of a straight line through the logarithms of its last four points: with slope 1,
twice the input takes twice the time.
"""

import csv
import math
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

# A point that takes longer than this [s] is measured once.
ONCE_FROM = 5.0
RUNS = 3
# Points that a slope is taken over.
LAST = 4


@dataclass
class Curve:
    """Calls that differ in one number."""

    name: str
    unit: str
    values: list[int]
    arguments: Callable[[int], str]


CURVES = [
    # All 36 assignments of two robots on four patterns.
    Curve(
        "items",
        "items in each of 4 patterns",
        [100, 300, 1_000, 3_000, 10_000, 30_000, 100_000],
        lambda n: f"--search exhaustive --validate 0 --patterns random:100/min:4 --items {n} --threads 1",
    ),
    # A race that cannot end early, as it asks for differences that do not exist: patterns are drawn, scored and
    # forgotten.
    Curve(
        "patterns",
        "patterns of 50 items",
        [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000],
        lambda n: "--race 1e-9 --confidence 0.999999 --patterns random:50/min --items 50 --threads 1"
        f" --max-patterns {n}",
    ),
    # The default patterns and the default search: an enumeration first, then GRASP and branch and bound.
    Curve("robots", "robots", list(range(1, 17)), lambda n: f"--robots {n} --threads 2"),
    Curve("threads", "threads", [1, 2], lambda n: f"--robots 4 --patterns balanced:960 --threads {n}"),
]


def run(program: str, arguments: str) -> tuple[float, float]:
    """Time [s] and largest resident set [MB] of one call."""
    began = time.perf_counter()
    process = subprocess.Popen(
        [program, "optimize", "--quiet", *arguments.split()], stdout=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"pickline optimize {arguments} failed")
    return seconds, usage.ru_maxrss / 1024


def measure(program: str, arguments: str) -> tuple[float, float]:
    """The shortest time [s] of a few calls, and the most memory [MB]."""
    runs = [run(program, arguments)]
    while len(runs) < RUNS and runs[0][0] < ONCE_FROM:
        runs.append(run(program, arguments))
    return min(seconds for seconds, _ in runs), max(memory for _, memory in runs)


def slope(points: list[tuple[int, float]]) -> float:
    """The slope of a straight line through the logarithms of the points, by least squares."""
    logarithms = [(math.log(x), math.log(y)) for x, y in points]
    mean_x = sum(x for x, _ in logarithms) / len(points)
    mean_y = sum(y for _, y in logarithms) / len(points)
    above = sum((x - mean_x) * (y - mean_y) for x, y in logarithms)
    return above / sum((x - mean_x) ** 2 for x, _ in logarithms)


def draw(rows: list[dict], path: Path) -> None:
    """Time and memory of the curves, side by side."""
    import matplotlib

    matplotlib.use("svg")
    # Equal figures give equal bytes.
    matplotlib.rcParams["svg.hashsalt"] = "pickline"
    from matplotlib import pyplot
    from matplotlib.ticker import MaxNLocator

    curves = [curve for curve in CURVES if curve.name != "threads"]
    figure, places = pyplot.subplots(2, len(curves), figsize=(11, 6), layout="constrained", sharey="row")
    for column, curve in enumerate(curves):
        of_curve = [row for row in rows if row["curve"] == curve.name]
        x = [row["x"] for row in of_curve]
        for place, key, label in ((0, "seconds", "time [s]"), (1, "memory_mb", "memory [MB]")):
            axes = places[place][column]
            axes.plot(x, [row[key] for row in of_curve], marker="o", color="#0072b2")
            axes.set_yscale("log")
            if curve.name == "robots":
                axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            else:
                axes.set_xscale("log")
            axes.grid(True, which="major", color="#dddddd")
            axes.set_axisbelow(True)
            if column == 0:
                axes.set_ylabel(label)
        places[0][column].set_title(f"time against {curve.name}")
        places[1][column].set_xlabel(curve.unit)
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    program, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    rows = []
    for curve in CURVES:
        for value in curve.values:
            arguments = curve.arguments(value)
            seconds, memory = measure(program, arguments)
            row = {"curve": curve.name, "x": value, "seconds": round(seconds, 3), "memory_mb": round(memory, 1)}
            rows.append(row | {"call": f"pickline optimize {arguments}"})
            print(f"{curve.name} {value}: {seconds:.3f} s, {memory:.1f} MB", file=sys.stderr)
    with (folder / "curves.csv").open("w", newline="") as file:
        file.write(f"# {version} on {os.cpu_count()} cores of {platform.machine()}: bash results/scaling/run.sh\n")
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, folder / "curves.svg")
    print("| time of `optimize` against | from | to | time [s] | memory [MB] | slope of the last four |")
    print("|---|---|---|---|---|---|")
    for curve in CURVES:
        of_curve = [row for row in rows if row["curve"] == curve.name]
        first, last = of_curve[0], of_curve[-1]
        tail = [(row["x"], row["seconds"]) for row in of_curve[-LAST:]]
        growth = "" if curve.name == "robots" else f"{slope(tail):.2f}"
        print(
            f"| {curve.unit} | {first['x']:,} | {last['x']:,} | {first['seconds']:.2f} to {last['seconds']:.2f}"
            f" | {first['memory_mb']:.0f} to {last['memory_mb']:.0f} | {growth} |"
        )


main()
