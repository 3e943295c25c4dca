#!/usr/bin/env bash
# Has the checker of the package onnx check the policy that ships and new ones of both
# networks.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv onnx
cargo build --locked --workspace --bin pickline
new=$target/tmp/onnx
rm -rf "$new"
mkdir -p "$new"
for preset in default paper; do
    "$target/debug/pickline" train --quiet --preset $preset --steps 2048 --out "$new/$preset.onnx"
done
"$python" - policies/pickline.onnx "$new"/*.onnx <<'CHECK'
import sys

import onnx

for path in sys.argv[1:]:
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    ports = [port.name for port in [*model.graph.input, *model.graph.output]]
    if ports != ["observation", "action_mask", "logits"]:
        sys.exit(f"{path}: ports {ports}")
    print(f"{path}: checked")
CHECK
