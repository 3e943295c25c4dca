#!/usr/bin/env bash
# Trains with RLlib for a few iterations, with the wheel WHEEL, which python/tests/run.sh makes.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/../../.."
. python/tests/torch.sh
# Debian's torch needs numpy 1, and pyarrow has to fit: not Debian's versions.
torch_venv rllib --ignore-installed
# Ray would keep a token of its cluster in the home folder, and report its use.
export RAY_AUTH_MODE=disabled RAY_USAGE_STATS_ENABLED=0
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider python/tests/rllib
