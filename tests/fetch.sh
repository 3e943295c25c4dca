#!/usr/bin/env bash
# Makes the virtual environments of all tests in Python, each by the functions of the test that uses it.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/venv.sh
. python/tests/torch.sh
for wanted in tests/*/requirements.txt; do
    name=$(basename "$(dirname "$wanted")")
    (venv "$name")
done
(venv python python/tests)
(torch_packages sb3)
(torch_packages rllib --ignore-installed)
