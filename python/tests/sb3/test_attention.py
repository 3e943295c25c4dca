"""The experiment with attention, and that its networks decide in Rust as they do in torch."""

import sys
from pathlib import Path

import pytest
import torch

import pickline
from pickline.environment import SortingEnv

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import attention  # noqa: E402


def picks_in_torch(network, station, pattern):
    """How many items the network picks, with its best action at every decision."""
    line = SortingEnv(station, [pattern], observation=attention.VIEW)
    seen, _ = line.reset(seed=1)
    ended = False
    while not ended:
        mask = torch.from_numpy(line.action_masks())[None]
        with torch.no_grad():
            action = int(network(torch.from_numpy(seen)[None], mask).argmax())
        seen, _, ended, _, told = line.step(action)
    return told["picked"], told["picking_rate"]


@pytest.mark.parametrize("name", attention.DESIGNS)
def test_the_rust_side_decides_as_the_network(name, tmp_path):
    torch.manual_seed(3)
    network = attention.Network(attention.DESIGNS[name]).eval()
    file = tmp_path / "network.onnx"
    attention.export(network, file)
    station = pickline.Station("paper")
    (pattern,) = pickline.patterns("poisson:0.12:1", station, items=40, seed=5)
    run = pickline.simulate(station, pattern, f"onnx:{file}")
    picked, rate = picks_in_torch(network, station, pattern)
    assert run.picked == picked > 10
    assert run.picking_rate == pytest.approx(rate, rel=1e-9)


def test_empty_slots_and_the_order_of_the_others_do_not_matter():
    torch.manual_seed(4)
    rows = torch.randn(5, attention.GLOBALS + attention.SLOTS * attention.FEATURES)
    mask = torch.rand(5, attention.SLOTS) < 0.5
    mask[:, 0] = True
    slots = rows[:, attention.GLOBALS :].reshape(5, attention.SLOTS, attention.FEATURES)
    order = torch.randperm(attention.SLOTS)
    other = torch.where(mask[:, :, None], slots, torch.randn_like(slots))[:, order]
    other = torch.cat([rows[:, : attention.GLOBALS], other.flatten(1)], 1)
    for design in attention.DESIGNS.values():
        network = attention.Network(design).eval()
        with torch.no_grad():
            logits, again = network(rows, mask), network(other, mask[:, order])
        torch.testing.assert_close(again, logits[:, order], rtol=1e-4, atol=1e-5)


def test_the_experiment_prints_its_tables(capsys):
    small = ["--patterns", "2", "--held-out", "1", "--epochs", "1", "--batch", "64", "--seeds", "1"]
    attention.main([*small, "--replicates", "1", "--items", "60"])
    lines = capsys.readouterr().out.splitlines()
    for name in attention.DESIGNS:
        assert any(line.startswith(f"| {name} |") for line in lines)
    cases = [line for line in lines if "150 items" in line]
    assert len(cases) == 8 and all(line.count("|") == 8 for line in cases)
