#!/usr/bin/env bash
# Builds the Python package as pip does and tests it in a virtual environment of its own. Needs Rust,
# Python 3.11 or later with venv, and PyPI once. The build shares target/debug with cargo's.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv python python/tests
# The profile of the other tests, so that what they have built serves here too.
export MATURIN_PEP517_ARGS="--profile dev --locked"
CARGO_TARGET_DIR=$target "$venv/bin/pip" install --quiet --disable-pip-version-check \
    --no-build-isolation --no-deps --force-reinstall ./python
"$python" -m pytest --quiet -p no:cacheprovider python/tests
"$venv/bin/pickline" --version
