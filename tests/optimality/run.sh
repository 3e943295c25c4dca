#!/usr/bin/env bash
# Holds look-ahead, the bound and the benchmark to the optimum of small lines, as CP-SAT and HiGHS find it. With --all
# larger lines as well, which take minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv optimality
cargo build --locked --quiet --workspace --bin pickline
"$python" tests/optimality/exact.py "$target/debug/pickline" --seconds 10 "$@"
