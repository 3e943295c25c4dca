#!/usr/bin/env bash
# Reads the metrics of a running line with the reference parser of Prometheus' client library
# for Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv metrics
# Arguments go to `cargo build`.
cargo build --locked --quiet --workspace --bin pickline "$@"
"$python" tests/metrics/read.py "$target/debug/pickline"
