"""Whether self-attention over the slots imitates the look-ahead better than the scorer that ships.

    python python/benchmarks/attention.py

The networks learn the same answers of the look-ahead with the same optimiser: on random patterns of the
stations ``paper`` and ``paper-narrow``, none of which is reported. Printed are the share of the same answers
on held-out episodes, the picking rates on the dense cases, paired with those of the scorer, and the time of a
decision. Needs torch; see ``python/tests/torch.sh``.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

import pickline
from pickline._pickline import demonstrate
from pickline.conditions import conditions

VIEW = "full"
SLOTS = 16
GLOBALS, FEATURES = 21, 17
"""Sizes of the view ``full``; ``src/decision/observation/full.rs``."""

SPACING = (0.09, 0.2)
"""Grid spacings and Poisson disk radii of the patterns to learn from [m]."""
ITEMS = (50, 200)
GRIDS = 0.2
"""Share of grids among the patterns."""

STATIONS = ("paper", "paper-narrow")
NEVER = -1e9
"""The logit of an empty slot, before a softmax."""


@dataclass(frozen=True)
class Design:
    """An architecture, by its sizes."""

    width: int
    layers: int = 0
    """Layers of self-attention between the two layers of the scorer."""
    feed_forward: bool = False
    """Whether two more linear layers follow each of them, as in a transformer."""


DESIGNS = {
    "scorer": Design(96),
    "one layer of attention": Design(64, 1),
    "two layers of attention": Design(52, 2),
    "wide scorer": Design(156),
    "two layers of a transformer": Design(64, 2, feed_forward=True),
}
"""The first three have the same number of parameters, and so have the last two."""
LARGE = ("wide scorer", "two layers of a transformer")
HEADS = 4


class Attention(nn.Module):
    """A layer of a set transformer (Lee et al., arXiv 1810.00825): every slot looks at all that hold an item."""

    def __init__(self, width: int, feed_forward: bool) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(width)
        self.seen = nn.Linear(width, 3 * width)
        self.out = nn.Linear(width, width)
        self.after = (
            nn.Sequential(
                nn.LayerNorm(width), nn.Linear(width, 2 * width), nn.ReLU(), nn.Linear(2 * width, width)
            )
            if feed_forward
            else None
        )

    def forward(self, slots: Tensor, present: Tensor) -> Tensor:
        """New vectors of the slots [rows, slots, width], of which those that are ``present`` count."""
        rows, _, width = slots.shape
        parts = self.seen(self.norm(slots)).reshape(rows, SLOTS, 3, HEADS, width // HEADS)
        query, key, value = parts.permute(2, 0, 3, 1, 4).unbind(0)
        alike = query @ key.transpose(2, 3) * (width // HEADS) ** -0.5
        weights = torch.softmax(alike.masked_fill(~present[:, None, None, :], NEVER), 3)
        slots = slots + self.out((weights @ value).transpose(1, 2).reshape(rows, SLOTS, width))
        return slots if self.after is None else slots + self.after(slots)


class Network(nn.Module):
    """The scorer of ``src/nn/scorer.rs``, with layers of attention before its slots are pooled."""

    def __init__(self, design: Design) -> None:
        super().__init__()
        width = design.width
        self.slot = nn.Linear(FEATURES, width, bias=False)
        self.globals = nn.Linear(GLOBALS, width)
        self.layers = nn.ModuleList(Attention(width, design.feed_forward) for _ in range(design.layers))
        self.own = nn.Linear(width, width, bias=False)
        self.context = nn.Linear(2 * width, width)
        self.logit = nn.Linear(width, 1, bias=False)

    def forward(self, observation: Tensor, action_mask: Tensor) -> Tensor:
        """The logits [rows, slots] of observations [rows, numbers] and which slots hold an item."""
        slots = observation[:, GLOBALS:].reshape(-1, SLOTS, FEATURES)
        slots = torch.relu(self.slot(slots) + self.globals(observation[:, :GLOBALS])[:, None])
        for layer in self.layers:
            slots = layer(slots, action_mask)
        held = action_mask[:, :, None]
        mean = (slots * held).sum(1) / held.sum(1)
        largest = slots.masked_fill(~held, NEVER).amax(1)
        context = self.context(torch.cat([mean, largest], 1))
        scores = self.logit(torch.relu(self.own(slots) + context[:, None]))[:, :, 0]
        return scores.masked_fill(~action_mask, NEVER)


@dataclass(frozen=True)
class Answers:
    """What the look-ahead does, a row for every decision."""

    observations: Tensor
    masks: Tensor
    actions: Tensor

    def __len__(self) -> int:
        return len(self.actions)


def patterns_to_learn(station: pickline.Station, count: int, seed: int) -> list[pickline.Pattern]:
    """Random patterns, dense ones more often than sparse ones."""
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(count):
        low, high = SPACING
        spacing = low + (high - low) * rng.random() ** 2
        kind = f"grid:{spacing:.4f}" if rng.random() < GRIDS else f"poisson:{spacing:.4f}:1"
        items, own = int(rng.integers(*ITEMS, endpoint=True)), int(rng.integers(2**31))
        drawn += pickline.patterns(kind, station, items=items, seed=own)
    return drawn


def answers(count: int, seed: int) -> Answers:
    """The look-ahead's answers on ``count`` patterns of each station."""
    parts: dict[str, list[NDArray]] = {"observations": [], "masks": [], "actions": []}
    for number, name in enumerate(STATIONS):
        station = pickline.Station(name)
        patterns = patterns_to_learn(station, count, 1000 * seed + number)
        _, episodes = demonstrate(
            station, patterns, "lookahead", conditions(), VIEW, SLOTS, False, (1.0, 1.0), 1, None
        )
        for episode in episodes:
            # The last row is what is seen at the end, where nothing is decided.
            parts["observations"].append(episode["observations"][:-1])
            parts["masks"].append(episode["masks"][:-1])
            parts["actions"].append(episode["actions"])
    return Answers(*(torch.from_numpy(np.concatenate(part)) for part in parts.values()))


def train(design: Design, data: Answers, epochs: int, batch: int, seed: int) -> Network:
    """Learn answers: Adam with a rate that falls linearly to 0, as in ``src/rl/imitation.rs``."""
    torch.manual_seed(seed)
    network = Network(design)
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-3)
    steps = epochs * (len(data) // batch)
    schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda step: 1 - step / steps)
    for _ in range(epochs):
        order = torch.randperm(len(data))
        for first in range(0, len(data) // batch * batch, batch):
            rows = order[first : first + batch]
            logits = network(data.observations[rows], data.masks[rows])
            optimiser.zero_grad()
            nn.functional.cross_entropy(logits, data.actions[rows]).backward()
            optimiser.step()
            schedule.step()
    return network.eval()


@torch.no_grad()
def agreement(network: Network, data: Answers) -> float:
    """The share of the same answers [%]."""
    same = 0
    for first in range(0, len(data), 4096):
        part = slice(first, first + 4096)
        best = network(data.observations[part], data.masks[part]).argmax(1)
        same += int((best == data.actions[part]).sum())
    return 100 * same / len(data)


def export(network: Network, file: Path) -> None:
    """Write a network for ``--strategy onnx:FILE``."""
    example = (torch.zeros(1, GLOBALS + SLOTS * FEATURES), torch.ones(1, SLOTS, dtype=torch.bool))
    names = {"input_names": ["observation", "action_mask"], "output_names": ["logits"]}
    # Newer versions of torch have another exporter by default.
    old = {} if "dynamo" not in torch.onnx.export.__code__.co_varnames else {"dynamo": False}
    torch.onnx.export(network, example, str(file), opset_version=13, **names, **old)


def decision_times(files: Sequence[Path], items: int, rounds: int) -> list[float]:
    """The mean time of a decision [us] of each network on one thread, the median of some rounds."""
    station = pickline.Station("paper")
    (short,) = pickline.patterns("poisson:0.12:1", station, items=5, seed=31)
    (long,) = pickline.patterns("poisson:0.12:1", station, items=items, seed=31)
    times: list[list[float]] = [[] for _ in files]
    for _ in range(rounds):
        for own, file in zip(times, files, strict=True):
            # A short run is the time to read the file.
            spent, picks = [], []
            for pattern in (short, long):
                began = time.perf_counter()
                run = pickline.simulate(station, pattern, f"onnx:{file}")
                spent.append(time.perf_counter() - began)
                picks.append(run.picked)
            own.append(1e6 * (spent[1] - spent[0]) / (picks[1] - picks[0]))
    return [statistics.median(own) for own in times]


def rates(files: dict[str, list[Path]], replicates: int) -> dict[tuple[str, str], dict[str, NDArray]]:
    """By station and case, the picking rates [1/min, patterns] of each design, the mean over its seeds."""
    found: dict[tuple[str, str], dict[str, NDArray]] = {}
    written = {f"onnx:{file}": design for design, own in files.items() for file in own}
    for station in STATIONS:
        compared = pickline.compare(
            station,
            "dense",
            strategy=[*written, "lookahead"],
            replicates=replicates,
            robust="SPT,FIFO",
            greedy=False,
            policy=False,
            bound=False,
        )
        runs = compared.runs
        for case in compared.cases:
            own: dict[str, list[NDArray]] = {}
            for method in compared.methods:
                rows = (runs.case == case) & (runs.method == method)
                name = written.get(method, method)
                own.setdefault(name, []).append(runs.picking_rate_per_min[rows])
            found[station, case] = {name: np.mean(seeds, axis=0) for name, seeds in own.items()}
    return found


def interval(differences: NDArray) -> str:
    """The mean of paired differences with its 95 % interval."""
    mean = differences.mean()
    if len(differences) < 2:
        return f"{mean:+.2f}"
    half = 1.96 * differences.std(ddof=1) / len(differences) ** 0.5
    return f"{mean:+.2f} [{mean - half:+.2f}, {mean + half:+.2f}]"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--patterns", type=int, default=200, help="to learn from, of each station")
    parser.add_argument("--held-out", type=int, default=40, help="patterns of each station")
    parser.add_argument("--epochs", type=int, default=6, help="passes over the answers")
    parser.add_argument("--batch", type=int, default=256, help="answers in a step")
    parser.add_argument("--seeds", type=int, default=2, help="trainings of each small network")
    parser.add_argument("--large-seeds", type=int, default=1, help="trainings of each large network")
    parser.add_argument("--replicates", type=int, default=100, help="patterns of each random case")
    parser.add_argument("--items", type=int, default=3000, help="items of the run that is timed")
    parser.add_argument("--out", type=Path, help="folder for the networks; not kept if not given")
    chosen = parser.parse_args(arguments)
    # On one thread, sums do not depend on the machine.
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as temporary:
        folder = chosen.out or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        learn, test = answers(chosen.patterns, 1), answers(chosen.held_out, 2)
        print(f"{len(learn)} answers to learn from, {len(test)} held out\n", flush=True)
        files: dict[str, list[Path]] = {}
        told: dict[str, tuple[int, list[float]]] = {}
        for name, design in DESIGNS.items():
            for seed in range(1, 1 + (chosen.large_seeds if name in LARGE else chosen.seeds)):
                network = train(design, learn, chosen.epochs, chosen.batch, seed)
                file = folder / f"{name.replace(' ', '-')}-{seed}.onnx"
                export(network, file)
                files.setdefault(name, []).append(file)
                size = sum(part.numel() for part in network.parameters())
                told.setdefault(name, (size, []))[1].append(agreement(network, test))
                print(f"trained: {file.name}", file=sys.stderr, flush=True)
        spent = decision_times([own[0] for own in files.values()], chosen.items, 5)
        print("| network | parameters | same answers [%] | decision [us] |\n|---|---|---|---|")
        for (name, (size, shares)), each in zip(told.items(), spent, strict=True):
            same = " / ".join(f"{share:.1f}" for share in shares)
            print(f"| {name} | {size:,} | {same} | {each:.0f} |")
        found = rates(files, chosen.replicates)
        names = [*files, "lookahead"]
        print(f"\n| station, case | {' | '.join(names)} |\n|---|{'---|' * len(names)}")
        for (station, case), own in found.items():
            first = own["scorer"]
            cells = [f"{first.mean():.1f}", *(interval(own[name] - first) for name in names[1:])]
            print(f"| {station}, {case} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
