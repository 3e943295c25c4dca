#!/usr/bin/env bash
# Tests the adapter for Stable-Baselines3 with the wheel WHEEL, which python/tests/run.sh makes.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/../../.."
. python/tests/torch.sh
torch_venv sb3
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider python/tests/sb3
