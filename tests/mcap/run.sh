#!/usr/bin/env bash
# Reads recordings of live runs with the mcap package of Python, as others would.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv mcap
# Writes the recordings. Arguments go to `cargo test`, as in tests/run.sh.
rm -rf "$target/tmp/mcap"
cargo test --locked --quiet --test live_recording "$@"
"$python" tests/mcap/read.py "$target/tmp/mcap"
