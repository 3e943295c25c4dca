#!/usr/bin/env bash
# Holds pickline to the model written as a SimPy program. With --benchmark, measures both instead
# (docs/speed.md).
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv simpy
if [ "${1:-}" = --benchmark ]; then
    shift
    exec "$python" tests/simpy/benchmark.py "$@"
fi
cargo build --locked --quiet --workspace --bin pickline
"$python" tests/simpy/equal.py "$target/debug/pickline"
