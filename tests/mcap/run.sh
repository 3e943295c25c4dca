#!/usr/bin/env bash
# Reads recordings of live runs as others would: with Foxglove's library, and with the mcap
# package of Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
. tests/modules.sh
venv mcap
modules mcap
# Writes the recordings. Arguments go to `cargo test`, as in tests/run.sh.
rm -rf "$target/tmp/mcap"
cargo test --locked --quiet --workspace --test live recording:: "$@"
found=$(node tests/mcap/read.mjs "$target/tmp/mcap")
"$python" tests/mcap/read.py "$target/tmp/mcap" "$found"
