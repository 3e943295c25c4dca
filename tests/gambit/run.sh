#!/usr/bin/env bash
# Holds `pickline game` to Gambit: the same pure equilibria from an independent solver.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv gambit
# Also builds the program, and writes the games whose answers the library computes.
rm -rf "$target/tmp/gambit"
cargo test --locked --quiet --workspace --test search -- --exact game::games_are_written_for_gambit
"$python" tests/gambit/compare.py "$target/debug/pickline" "$target/tmp/gambit"
