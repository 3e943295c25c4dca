#!/usr/bin/env bash
# Holds the trapezoidal travel-time law to ruckig, a trajectory generator: the same times for moves
# from rest to rest, and how much less a move takes that ends with the belt's velocity.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv ruckig
rm -rf "$target/tmp/ruckig"
cargo test --locked --quiet --workspace --test simulation -- --exact real_lines::moves_are_written_for_ruckig
"$python" tests/ruckig/compare.py "$target/tmp/ruckig/moves.csv"
