"""Writes the instances of the benchmark: a station and a pattern each, with `pickline station show` and
`pickline pattern generate`, and the list of their names if there is none yet.

usage: python3 patterns/benchmark/make.py PICKLINE [FOLDER]

With --solve it then finds what is known of them, bounds and best known solutions, and keeps what is better than
before. To make all of it again:

    rm -r patterns/benchmark/best patterns/benchmark/instances.csv
    python3 patterns/benchmark/make.py target/release/pickline --solve
"""

import argparse
import subprocess
from pathlib import Path

# Of each station: robots, belt speed [m/s] (None: the station's), feed with its density, items, seed. The
# density is the spacing of a grid, the radius of a Poisson disk pattern [m] or a flow [1/min].
INSTANCES = {
    "paper": [
        # Small enough to be solved to proven optimality by tests/optimality.
        (2, 0.2, "poisson", 0.12, 20, 1),
        (3, 0.25, "poisson", 0.12, 20, 2),
        (2, 0.15, "grid", 0.15, 20, 1),
        (2, 0.25, "poisson", 0.15, 20, 3),
        # Sparse to beyond capacity.
        (2, None, "grid", 0.3, 50, 1),
        (2, None, "grid", 0.15, 50, 1),
        (2, None, "poisson", 0.3, 50, 1),
        (2, None, "poisson", 0.2, 50, 2),
        (2, None, "poisson", 0.15, 150, 1),
        (2, None, "poisson", 0.12, 150, 1),
        (2, None, "poisson", 0.12, 150, 2),
        (2, None, "poisson", 0.1, 150, 1),
        (2, None, "grid", 0.15, 150, 1),
        (2, None, "random", 60, 150, 1),
        (2, None, "clustered", 60, 150, 1),
        (3, None, "poisson", 0.1, 150, 1),
        (3, 0.1, "poisson", 0.12, 150, 1),
        (4, 0.1, "grid", 0.15, 150, 1),
        (4, 0.12, "poisson", 0.12, 200, 1),
        (5, 0.1, "gaps", 200, 300, 1),
        (6, 0.15, "poisson", 0.12, 300, 1),
        (8, 0.2, "poisson", 0.12, 300, 1),
        (3, None, "random", 100, 500, 1),
        (4, 0.1, "poisson", 0.15, 500, 1),
        (2, None, "poisson", 0.12, 1000, 1),
    ],
    "paper-narrow": [
        (2, 0.25, "poisson", 0.1, 20, 3),
        (2, 0.2, "poisson", 0.12, 20, 1),
        (2, 0.2, "grid", 0.15, 20, 1),
        (3, 0.3, "poisson", 0.1, 20, 2),
        (2, None, "grid", 0.3, 50, 1),
        (2, None, "grid", 0.15, 50, 1),
        (2, None, "poisson", 0.2, 50, 1),
        (2, None, "poisson", 0.12, 50, 2),
        (2, None, "poisson", 0.15, 150, 1),
        (2, None, "poisson", 0.12, 150, 1),
        (2, None, "poisson", 0.1, 150, 1),
        (2, None, "poisson", 0.1, 150, 2),
        (2, None, "grid", 0.15, 150, 1),
        (2, None, "random", 60, 150, 1),
        (2, None, "clustered", 60, 150, 1),
        (3, None, "poisson", 0.1, 150, 1),
        (3, 0.12, "poisson", 0.12, 150, 1),
        (4, 0.15, "poisson", 0.12, 150, 1),
        (4, None, "gaps", 120, 300, 1),
        (5, 0.2, "poisson", 0.12, 300, 1),
        (6, 0.2, "grid", 0.15, 300, 1),
        (8, 0.3, "poisson", 0.12, 300, 1),
        (3, None, "random", 90, 500, 1),
        (4, 0.15, "poisson", 0.1, 500, 1),
        (2, None, "poisson", 0.1, 1000, 1),
    ],
    "delta": [
        (2, 0.8, "poisson", 0.06, 20, 4),
        (2, 0.8, "poisson", 0.08, 20, 1),
        (3, 1.0, "poisson", 0.06, 20, 2),
        (2, 0.6, "grid", 0.06, 20, 1),
        (2, None, "poisson", 0.2, 50, 1),
        (2, None, "poisson", 0.12, 50, 1),
        (2, None, "grid", 0.1, 50, 1),
        (2, None, "poisson", 0.1, 150, 1),
        (2, None, "poisson", 0.08, 150, 1),
        (2, None, "random", 300, 150, 1),
        (2, None, "clustered", 240, 150, 1),
        (3, None, "poisson", 0.15, 150, 1),
        (3, None, "poisson", 0.1, 150, 1),
        (3, None, "poisson", 0.1, 150, 2),
        (3, None, "poisson", 0.08, 150, 1),
        (3, None, "grid", 0.1, 150, 1),
        (3, 0.6, "poisson", 0.1, 150, 1),
        (3, 0.5, "gaps", 500, 300, 1),
        (4, 0.6, "poisson", 0.1, 300, 1),
        (5, 0.8, "poisson", 0.1, 300, 1),
        (6, 0.8, "grid", 0.1, 300, 1),
        (8, 0.8, "poisson", 0.08, 300, 1),
        (3, None, "random", 400, 500, 1),
        (4, 0.5, "poisson", 0.1, 500, 1),
        (3, None, "poisson", 0.1, 1000, 1),
    ],
    "sorting": [
        (2, 0.6, "poisson", 0.1, 20, 1),
        (3, 0.8, "poisson", 0.1, 20, 2),
        (2, 0.5, "grid", 0.15, 20, 1),
        (2, None, "poisson", 0.3, 50, 1),
        (2, None, "poisson", 0.2, 50, 1),
        (2, None, "grid", 0.15, 50, 1),
        (2, None, "poisson", 0.12, 150, 1),
        (2, None, "random", 150, 150, 1),
        (2, None, "clustered", 120, 150, 1),
        (3, None, "poisson", 0.15, 150, 1),
        (3, None, "poisson", 0.12, 150, 1),
        (3, None, "gaps", 240, 150, 1),
        (4, None, "poisson", 0.2, 150, 1),
        (4, None, "poisson", 0.15, 150, 1),
        (4, None, "poisson", 0.12, 150, 1),
        (4, None, "poisson", 0.12, 150, 2),
        (4, None, "poisson", 0.1, 150, 1),
        (4, None, "grid", 0.15, 150, 1),
        (4, 0.4, "poisson", 0.12, 150, 1),
        (5, 0.4, "poisson", 0.15, 200, 1),
        (6, 0.4, "poisson", 0.12, 200, 1),
        (8, 0.6, "poisson", 0.12, 300, 1),
        (4, None, "random", 200, 300, 1),
        (4, None, "poisson", 0.15, 500, 1),
        (4, None, "random", 250, 1000, 1),
    ],
}
# What a belt of waste carries; a fifth of it stays there.
CLASSES = "pet:0.3,hdpe:0.3,paper:0.2,wood:0.2"
# Feeds of items that differ in size, and so in weight.
WEIGHED = ("random", "clustered", "gaps")
# What every instance is solved with: strategies that see the belt only, with the bounds and their schedules, and
# look-ahead that knows everything from the beginning, of up to 150 items.
SEARCHES = [
    ["--bounds", "--strategy=rules:SPT", "--strategy=rules:FIFO", "--strategy=share:1", "--strategy=zones"],
    ["--strategy=lookahead:budget=1000"],
    ["--track=clairvoyant", "--only=*-20-*", "--only=*-50-*", "--strategy=lookahead:budget=4000"],
    ["--track=clairvoyant", "--only=*-150-*", "--strategy=lookahead:budget=2000"],
]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("pickline")
    parser.add_argument("folder", nargs="?", default=Path(__file__).parent, type=Path)
    parser.add_argument("--solve", action="store_true", help="find bounds and solutions as well")
    options = parser.parse_args()

    def call(*arguments: str) -> str:
        line = [options.pickline, *arguments]
        return subprocess.run(line, check=True, stdout=subprocess.PIPE, encoding="utf-8").stdout

    for part in ("stations", "patterns"):
        (options.folder / part).mkdir(parents=True, exist_ok=True)
    names = []
    for station, rows in INSTANCES.items():
        for robots, speed, feed, density, items, seed in rows:
            faster = f"v{speed}-" if speed else ""
            name = f"{station}-{robots}r-{faster}{feed}-{density}-{items}-{seed}"
            names.append(name)
            line = ["--station", station, "--robots", str(robots)]
            line += ["--belt-speed", str(speed)] if speed else []
            (options.folder / "stations" / f"{name}.toml").write_text(call("station", "show", *line))
            key = {"grid": "--spacing", "poisson": "--radius"}.get(feed, "--flow")
            made = [key, str(density), "--count", str(items)]
            made += [] if feed == "grid" else ["--seed", str(seed)]
            if station == "sorting":
                made += ["--classes", CLASSES]
            elif feed in WEIGHED:
                made += ["--area", "lognormal:80,0.5"]
            pattern = call("pattern", "generate", feed, "--quiet", *line, *made)
            (options.folder / "patterns" / f"{name}.csv").write_text(pattern)
    manifest = options.folder / "instances.csv"
    if not manifest.exists():
        manifest.write_text("name\n" + "".join(f"{name}\n" for name in names))
    if options.solve:
        for search in SEARCHES:
            run = [options.pickline, "benchmark", "--dir", str(options.folder), "--update", *search]
            subprocess.run(run, check=True)


main()
