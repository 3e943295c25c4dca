"""Writes the policies that tests/learning/policy.rs reads as torch's two exporters make them: the
actor of a MaskablePPO of sb3-contrib, without its mask.

Needs sb3-contrib, torch 2.5 or later, onnx and onnxscript from PyPI. The committed files
were written with sb3-contrib 2.9.2, torch 2.15.0 and onnx 1.23.2.
"""

import json
import pathlib

import gymnasium
import onnx
import torch
from sb3_contrib import MaskablePPO

DATA = pathlib.Path(__file__).parents[1] / "data" / "policies"
OBSERVATION, ACTIONS = 52, 10


class Line(gymnasium.Env):
    """Only its spaces count: those of the paper's view."""

    observation_space = gymnasium.spaces.Box(-10, 10, (OBSERVATION,))
    action_space = gymnasium.spaces.Discrete(ACTIONS)


class Actor(torch.nn.Module):
    def __init__(self, policy):
        super().__init__()
        self.policy = policy

    def forward(self, observation):
        features = self.policy.extract_features(observation)
        latent, _ = self.policy.mlp_extractor(features)
        return self.policy.action_net(latent)


def check(file):
    """Checks a file, and drops where in which script its nodes come from."""
    model = onnx.load(file)
    onnx.checker.check_model(model)
    for node in model.graph.node:
        del node.metadata_props[:]
        node.doc_string = ""
    onnx.save(model, file)


def main():
    DATA.mkdir(exist_ok=True)
    model = MaskablePPO("MlpPolicy", Line(), policy_kwargs={"net_arch": [8]}, seed=1)
    actor = Actor(model.policy).eval()
    # Fresh actors hardly tell actions apart.
    torch.nn.init.normal_(model.policy.action_net.weight)
    row = torch.arange(OBSERVATION, dtype=torch.float32)[None] / OBSERVATION
    (DATA / "logits.json").write_text(json.dumps(actor(row)[0].tolist()) + "\n")
    for opset in range(17, 21):
        for batch in ["static", "dynamic"]:
            names = {"input_names": ["obs"], "output_names": ["action"], "opset_version": opset}
            file = DATA / f"legacy_{opset}_{batch}.onnx"
            axes = {"obs": {0: "n"}, "action": {0: "n"}} if batch == "dynamic" else None
            torch.onnx.export(actor, row, str(file), dynamo=False, dynamic_axes=axes, **names)
            check(file)
            if opset == 17:
                continue  # The new exporter begins with 18.
            file = DATA / f"dynamo_{opset}_{batch}.onnx"
            shapes = ({0: torch.export.Dim("n")},) if batch == "dynamic" else None
            rows = row.repeat(3, 1) if batch == "dynamic" else row
            torch.onnx.export(
                actor, (rows,), str(file), dynamo=True, external_data=False,
                dynamic_shapes=shapes, **names,
            )
            check(file)


if __name__ == "__main__":
    main()
