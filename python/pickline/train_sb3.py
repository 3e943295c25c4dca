"""Train a policy with MaskablePPO of sb3-contrib and write it as ONNX.

    python -m pickline.train_sb3 --out mine.onnx
    pickline compare --strategy onnx:mine.onnx

The settings are those of Jermann et al.: three million steps, 50 items in each of 240 grids and Poisson disk
patterns, the observation, the reward and the network (64-64, tanh), and otherwise the defaults of
Stable-Baselines3. Their curriculum, from sparse to dense patterns, is left out: every episode has any of the
patterns. Besides the policy it writes its learning curve as CSV, a row for every case of an evaluation. The
cases have the patterns of the curve of ``pickline train``, and no pattern of theirs is trained on.

Needs ``pip install './python[sb3]'``. From PyPI, torch comes with CUDA (3 GB); a torch without it will do.
"""

from __future__ import annotations

import argparse
import csv
import importlib.util
import itertools
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import pickline
from pickline._parts import ObservationName
from pickline.environment import SortingEnv

if TYPE_CHECKING:
    from sb3_contrib import MaskablePPO

__all__ = ["evaluate", "export", "main", "train"]

EXPORTERS = ("torchscript", "dynamo")
OPSET = 18
"""Version of the ONNX operators of the dynamo exporter; the oldest that it has."""

COLUMNS = ("picked_share", "picking_rate_per_min", "weighted_rate_per_min")
"""What an evaluation says of a case: means over its patterns."""

Figures = dict[str, float]


def evaluate(
    model: MaskablePPO, cases: Mapping[str, Sequence[SortingEnv]], seed: int = 0
) -> dict[str, Figures]:
    """Let a policy take its best actions on every line of every case once, together.

    Args:
        model: The policy.
        cases: By its name, the environments of each case, with one pattern each.
        seed: Seed of what is random on the lines.

    Returns:
        For each case the means over its lines: ``picked_share``, ``picking_rate_per_min`` and
        ``weighted_rate_per_min`` [1/min].
    """
    lines = [line for own in cases.values() for line in own]
    at_work = dict(enumerate(line.reset(seed=seed)[0] for line in lines))
    ends: dict[int, tuple[float, ...]] = {}
    while at_work:
        indices = list(at_work)
        masks = np.stack([lines[index].action_masks() for index in indices])
        observations = np.stack([at_work[index] for index in indices])
        actions, _ = model.predict(observations, action_masks=masks, deterministic=True)
        for index, action in zip(indices, actions, strict=True):
            at_work[index], _, ended, _, info = lines[index].step(action)
            if ended:
                del at_work[index]
                share = info["picked"] / info["items"]
                ends[index] = (share, info["picking_rate"], info["weighted_rate"])
    figures, first = {}, 0
    for name, own in cases.items():
        means = np.mean([ends[first + place] for place in range(len(own))], axis=0)
        figures[name] = dict(zip(COLUMNS, means.tolist(), strict=True))
        first += len(own)
    return figures


def export(model: MaskablePPO, file: str | Path, exporter: str = "torchscript") -> None:
    """Write the actor of a policy as an ONNX file, which ``--strategy onnx:FILE`` of the program reads.

    Args:
        model: A policy whose observations are vectors.
        file: The file.
        exporter: ``torchscript``, which every version of torch has, or ``dynamo``, from torch 2.5 on,
            which needs the package onnxscript.

    Raises:
        ValueError: An exporter that there is not.
    """
    import torch

    if exporter not in EXPORTERS:
        known = " or ".join(EXPORTERS)
        raise ValueError(f"exporter: {exporter!r} is unknown\n  cure: give {known}")

    class Actor(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.policy = model.policy

        def forward(self, observation: torch.Tensor) -> torch.Tensor:
            extracted = self.policy.extract_features(observation, self.policy.pi_features_extractor)
            return self.policy.action_net(self.policy.mlp_extractor.forward_actor(extracted))

    actor = Actor().to("cpu").eval()
    # Two rows, because exporters take a dimension of length one for a constant.
    example = torch.zeros((2, *model.observation_space.shape), dtype=torch.float32)
    names: dict[str, Any] = {"input_names": ["observation"], "output_names": ["logits"]}
    with torch.no_grad():
        if exporter == "dynamo":
            batch = torch.export.Dim("batch")
            torch.onnx.export(
                actor,
                (example,),
                str(file),
                dynamo=True,
                external_data=False,
                opset_version=OPSET,
                dynamic_shapes={"observation": {0: batch}},
                **names,
            )
        else:
            # Newer versions have the other exporter by default.
            old = {} if "dynamo" not in torch.onnx.export.__code__.co_varnames else {"dynamo": False}
            torch.onnx.export(
                actor,
                (example,),
                str(file),
                dynamic_axes={name: {0: "batch"} for name in ("observation", "logits")},
                **names,
                **old,
            )


def _fresh(
    patterns: Any, held_out: Iterable[pickline.Pattern], line: pickline.Station, items: int, seed: int
) -> list[pickline.Pattern]:
    """The patterns to train on, without those of the evaluations."""
    if isinstance(patterns, str):
        patterns = pickline.patterns(patterns, line, items=items, seed=seed)
    elif isinstance(patterns, pickline.Pattern):
        patterns = [patterns]
    tests = list(held_out)
    fresh = [pattern for pattern in patterns if pattern not in tests]
    if not fresh:
        raise ValueError(
            "patterns: the policy is evaluated on all of them\n"
            "  cure: give others, or another evaluate_on"
        )
    return fresh


def train(
    *,
    station: Any = "paper",
    patterns: Any = "balanced",
    items: int = 50,
    observation: ObservationName = "paper",
    steps: int = 3_000_000,
    envs: int = 8,
    seed: int = 1,
    evaluate_on: str = "all",
    evaluate_every: int | None = None,
    curve: str | Path | None = None,
    tensorboard: str | None = None,
    progress: bool = False,
) -> MaskablePPO:
    """Train with the settings of the paper's Table 1.

    Args:
        station: As for :class:`pickline.SortingEnv`, as are ``patterns``, ``items`` and
            ``observation``.
        steps: Decisions to learn from; a whole update of 2048 is always completed.
        envs: Environments, which share the 2048 decisions of an update.
        seed: Seed of weights, actions, episodes and the patterns to train on.
        evaluate_on: Cases of the evaluations: ``paper``, ``dense``, ``all`` or a file, as for
            :func:`pickline.compare`. Patterns of theirs are not trained on.
        evaluate_every: Steps between evaluations; a hundredth of ``steps`` if not given.
        curve: File for the learning curve.
        tensorboard: Folder for TensorBoard's logs.
        progress: Whether to show a progress bar; needs tqdm and rich.

    Returns:
        The trained policy. After Ctrl-C, as far as it has been trained.

    Raises:
        ValueError: A value that does not fit.
        OSError: A file that cannot be read or written.
        ImportError: A package that is missing.
    """
    import torch
    from sb3_contrib import MaskablePPO
    from stable_baselines3.common.callbacks import BaseCallback

    from pickline.sb3 import SortingVecEnv

    if 2048 % envs:
        raise ValueError(f"envs: {envs} does not divide the 2048 steps of an update\n  cure: give 8")
    torch.set_num_threads(1)
    line = pickline.Station(station) if not isinstance(station, pickline.Station) else station
    held_out = pickline.trials(line, evaluate_on)
    cases = {
        name: [SortingEnv(line, [pattern], observation=observation) for pattern in own]
        for name, own in held_out.items()
    }
    every = evaluate_every or max(1, steps // 100)

    class Evaluations(BaseCallback):
        """Evaluates as often as asked for, between updates, and at the end."""

        def __init__(self, writer: Any) -> None:
            super().__init__()
            self.writer = writer
            self.due = 0

        def evaluate(self) -> None:
            for case, figures in evaluate(self.model, cases, seed).items():
                for name, value in figures.items():
                    self.logger.record(f"{case}/{name}", value, exclude="stdout")
                if self.writer is not None:
                    self.writer.writerow([self.num_timesteps, case, *figures.values()])
            self.due = self.num_timesteps + every

        def _on_rollout_start(self) -> None:
            if self.num_timesteps >= self.due:
                self.evaluate()

        def _on_training_end(self) -> None:
            self.evaluate()

        def _on_step(self) -> bool:
            return True

    tests = itertools.chain.from_iterable(held_out.values())
    fresh = _fresh(patterns, tests, line, items, seed)
    env = SortingVecEnv(envs, line, fresh, observation=observation)
    model = MaskablePPO(
        "MlpPolicy",
        env,
        n_steps=2048 // envs,
        gamma=0.9995,
        policy_kwargs={"net_arch": [64, 64], "activation_fn": torch.nn.Tanh},
        tensorboard_log=tensorboard,
        seed=seed,
        device="cpu",
    )
    out = (
        open(curve, "w", buffering=1, newline="", encoding="utf-8") if curve is not None else None
    )
    try:
        writer = csv.writer(out) if out is not None else None
        if writer is not None:
            writer.writerow(["steps", "case", *COLUMNS])
        model.learn(steps, callback=Evaluations(writer), progress_bar=progress)
    except KeyboardInterrupt:
        print(f"interrupted after {model.num_timesteps} of {steps} steps", file=sys.stderr)
    finally:
        if out is not None:
            out.close()
        env.close()
    return model


def main(arguments: Sequence[str] | None = None) -> int:
    """The program: see ``python -m pickline.train_sb3 --help``."""
    parser = argparse.ArgumentParser(
        prog="python -m pickline.train_sb3",
        description="Train a policy with MaskablePPO and the settings of the paper, and write "
        "it as ONNX.",
        epilog="example: python -m pickline.train_sb3 --steps 300000 --out mine.onnx && "
        "pickline compare --strategy onnx:mine.onnx",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="the policy, FILE.onnx")
    parser.add_argument("--station", default="paper", help="a built-in station or a file")
    parser.add_argument("--patterns", default="balanced", metavar="SET", help="to train on")
    parser.add_argument("--items", type=int, default=50, metavar="N", help="items in each pattern")
    parser.add_argument("--observation", default="paper", choices=["paper", "full", "real"])
    parser.add_argument("--steps", type=int, default=3_000_000, metavar="N", help="decisions")
    parser.add_argument("--envs", type=int, default=8, metavar="N", help="environments")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument(
        "--evaluate-on",
        default="all",
        metavar="CASES",
        help="cases of the evaluations: paper, dense, all or a file, as for pickline compare",
    )
    parser.add_argument(
        "--evaluate-every", type=int, metavar="N", help="steps; a hundredth of all if not given"
    )
    parser.add_argument("--tensorboard", metavar="DIR", help="folder for TensorBoard's logs")
    parser.add_argument("--exporter", default="torchscript", choices=EXPORTERS, help="of torch")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    chosen = vars(parser.parse_args(arguments))
    file, exporter = chosen.pop("out"), chosen.pop("exporter")
    if file.suffix != ".onnx":
        print(f"--out: {file} does not end in .onnx\n  cure: name it so", file=sys.stderr)
        return 2
    curve = file.with_suffix(".csv")
    taken = [str(name) for name in (file, curve) if name.exists()]
    if taken:
        print(f"{taken[0]}: the file exists\n  cure: choose another name, or remove it", file=sys.stderr)
        return 2
    # The bar of Stable-Baselines3 needs both.
    can_draw = sys.stderr.isatty() and all(importlib.util.find_spec(name) for name in ("tqdm", "rich"))
    progress = not chosen.pop("quiet") and can_draw
    try:
        model = train(curve=curve, progress=progress, **chosen)
    except (ValueError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    except ImportError as error:
        print(f"{error}\n  cure: pip install stable-baselines3 sb3-contrib", file=sys.stderr)
        return 2
    export(model, file, exporter)
    return 0


if __name__ == "__main__":
    sys.exit(main())
