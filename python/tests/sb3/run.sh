#!/usr/bin/env bash
# Tests the adapter for Stable-Baselines3 with the wheel WHEEL (python/tests/run.sh makes it) on Debian's
# Python and torch: PyPI has no torch without CUDA, which is 3 GB.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/../../.."
. tests/debian.sh
debian /usr/lib/python3/dist-packages/torch=python3-torch
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
venv=$target/python-sb3-venv
wanted=python/tests/sb3/requirements.txt
if ! cmp --silent "$wanted" "$venv/installed.txt"; then
    /usr/bin/python3 -m venv --clear --system-site-packages "$venv"
    # Without their dependencies: they would bring another torch.
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --only-binary=:all: \
        --requirement "$wanted"
    cp "$wanted" "$venv/installed.txt"
fi
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheel"
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider python/tests/sb3
