#!/usr/bin/env bash
# Holds `pickline game` to Gambit: the same pure equilibria from an independent solver.
# Needs Python 3.11 or later with venv, and the network once; says so when they are missing.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
venv=$target/gambit-venv
stamp=$venv/installed.txt
fail() {
    echo "tests/gambit/run.sh: $1" >&2
    echo "  cure: $2" >&2
    exit 1
}
if ! cmp --silent tests/gambit/requirements.txt "$stamp"; then
    python3 -m venv --clear "$venv" ||
        fail "python3 -m venv failed" "install Python 3.11 or later with venv (Debian: apt install python3-venv)"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
        --requirement tests/gambit/requirements.txt ||
        fail "pygambit could not be installed from PyPI" \
            "give this machine access to PyPI once (it is kept in $venv) and Python 3.11 or later"
    cp tests/gambit/requirements.txt "$stamp"
fi
# Also builds the program, and writes the games whose answers the library computes.
rm -rf "$target/tmp/gambit"
cargo test --locked --quiet --test game -- --exact games_are_written_for_gambit
"$venv/bin/python" tests/gambit/compare.py "$target/debug/pickline" "$target/tmp/gambit"
