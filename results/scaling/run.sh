#!/usr/bin/env bash
# Measures how time and memory of `pickline optimize` grow: writes curves.csv and curves.svg here, or into the
# folder that the first argument names, and prints the slopes. Takes about half an hour on an idle machine.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "${1:-results/scaling}")
. tests/venv.sh
venv scaling results/scaling
if [ -z "${PICKLINE:-}" ]; then
    cargo build --release --locked --quiet --bin pickline
    PICKLINE=$target/release/pickline
fi
"$python" results/scaling/measure.py "$PICKLINE" "$out"
