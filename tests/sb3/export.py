"""Writes the policies that tests/policy.rs reads as torch's exporter makes them.

Needs Debian's python3-torch (1.13.1) and the package onnx; see record.py.
"""

import json
import pathlib

import torch

DATA = pathlib.Path(__file__).parents[1] / "data"


def main():
    torch.manual_seed(1)
    net = torch.nn.Sequential(torch.nn.Linear(52, 8), torch.nn.Tanh(), torch.nn.Linear(8, 10))
    row = torch.arange(52, dtype=torch.float32)[None] / 52
    (DATA / "torch_logits.json").write_text(json.dumps(net(row)[0].tolist()) + "\n")
    for name, axes in [("static", None), ("dynamic", {"obs": {0: "n"}, "action": {0: "n"}})]:
        torch.onnx.export(
            net, row, str(DATA / f"torch_{name}.onnx"), opset_version=17,
            input_names=["obs"], output_names=["action"], dynamic_axes=axes,
        )


if __name__ == "__main__":
    main()
