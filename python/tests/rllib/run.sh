#!/usr/bin/env bash
# Trains with RLlib for a few iterations, with the wheel WHEEL (python/tests/run.sh makes it) on Debian's
# Python and torch: PyPI has no torch without CUDA, which is 3 GB.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/../../.."
. tests/debian.sh
debian /usr/lib/python3/dist-packages/torch=python3-torch
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
venv=$target/python-rllib-venv
wanted=python/tests/rllib/requirements.txt
if ! cmp --silent "$wanted" "$venv/installed.txt"; then
    /usr/bin/python3 -m venv --clear --system-site-packages "$venv"
    # Debian's torch needs numpy 1, and pyarrow has to fit.
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --only-binary=:all: \
        --ignore-installed --requirement "$wanted"
    cp "$wanted" "$venv/installed.txt"
fi
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheel"
# Ray would keep a token of its cluster in the home folder, and report its use.
export RAY_AUTH_MODE=disabled RAY_USAGE_STATS_ENABLED=0
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider python/tests/rllib
