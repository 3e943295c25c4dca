"""Holds pickline's games to Gambit's solver, https://www.gambit-project.org.

Usage: compare.py PROGRAM FOLDER

Loads the .nfg of every game below, has pygambit enumerate the pure equilibria, and
checks that they are exactly those of the JSON, and that Gambit read exactly the
payoffs of the JSON, as rational numbers. PROGRAM is the pickline binary; FOLDER holds
NAME.nfg with NAME.json that tests/search/game.rs wrote: games with known answers and random
ones full of ties.
"""

import json
import subprocess
import sys
import tempfile
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pygambit

# Arguments of `pickline game`; each is solved for both payoffs.
LINES = [
    [],
    ["--robots", "3"],
    ["--robots", "1"],
    ["--robots", "4", "--patterns", "balanced:6"],
    ["--station", "paper-narrow", "--items", "50"],
    ["--station", "paper-narrow", "--items", "50", "--robots", "3"],
    ["--patterns", "grid:0.15", "--items", "20"],
    ["--patterns", "grid:0.2", "--items", "50", "--robots", "3"],
    ["--patterns", "poisson:0.12:10", "--area", "lognormal:80,0.5"],
    ["--patterns", "balanced:10", "--p-grasp", "beta:8,2", "--robots", "3"],
    # Robots so close that their windows overlap: the event loop.
    ["--station", str(Path(__file__).parent / "close.toml"), "--patterns", "balanced:10"],
    # So fast a belt that SD is best.
    ["--patterns", "poisson:0.3:4", "--belt-speed", "0.3", "--robots", "3"],
]


def read_json(path):
    return json.loads(path.read_text(), parse_float=Decimal, parse_int=Decimal)


def pure(game, profile):
    """The one strategy that each player chooses, upstream first."""
    chosen = []
    for player in game.players:
        sure = [s for s in game.get_strategies(player) if profile[player][s] == 1]
        assert len(sure) == 1, f"{profile} is no pure profile"
        chosen.append(sure[0])
    return tuple(chosen)


def compare(name, nfg, ours):
    """Raises where Gambit disagrees; returns the number of equilibria."""
    game = pygambit.read_nfg(str(nfg))
    players = list(game.players)
    assert players == ours["robots"], f"{name}: players {players}"
    for line in ours["profiles"]:
        theirs = game.get_payoffs(dict(zip(players, line["assignment"])))
        for player, payoff in zip(players, line["payoffs"]):
            theirs_exact = Fraction(str(theirs[player]))
            assert theirs_exact == Fraction(payoff), (
                f"{name}: {line['assignment']} pays {player} {payoff}, "
                f"Gambit read {theirs_exact}"
            )
    result = pygambit.nash.enumpure_solve(game)
    theirs = sorted(pure(game, profile) for profile in result.equilibria)
    mine = sorted(tuple(line["assignment"]) for line in ours["equilibria"])
    assert mine == theirs, f"{name}: ours {mine}, Gambit's {theirs}"
    return len(mine)


def main(program, folder):
    counts = []
    with tempfile.TemporaryDirectory() as temporary:
        for line in LINES:
            for payoff in ["own", "total"]:
                out = Path(temporary) / str(len(counts))
                call = ["game", "--quiet", "--payoff", payoff, *line, "--out", str(out)]
                subprocess.run([program, *call], check=True, stdout=subprocess.DEVNULL)
                ours = read_json(out / "game.json")
                counts.append(compare(" ".join(call), out / "game.nfg", ours))
                print(f"{counts[-1]:5} equilibria  pickline {' '.join(call[:-2])}")
    written = sorted(Path(folder).glob("*.json"))
    assert len(written) > 100, f"{folder} holds {len(written)} games"
    for path in written:
        counts.append(compare(path.stem, path.with_suffix(".nfg"), read_json(path)))
    print(
        f"Gambit {pygambit.__version__} agrees on all {len(counts)} games: "
        f"{sum(counts)} equilibria, {counts.count(0)} games with none"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
