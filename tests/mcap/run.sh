#!/usr/bin/env bash
# Reads recordings of live runs with the mcap package of Python, as others would.
# Needs Python 3.11 or later with venv, and the network once; says so when they are missing.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
venv=$target/mcap-venv
stamp=$venv/installed.txt
fail() {
    echo "tests/mcap/run.sh: $1" >&2
    echo "  cure: $2" >&2
    exit 1
}
if ! cmp --silent tests/mcap/requirements.txt "$stamp"; then
    python3 -m venv --clear "$venv" ||
        fail "python3 -m venv failed" "install Python 3.11 or later with venv (Debian: apt install python3-venv)"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
        --requirement tests/mcap/requirements.txt ||
        fail "mcap could not be installed from PyPI" \
            "give this machine access to PyPI once (it is kept in $venv) and Python 3.11 or later"
    cp tests/mcap/requirements.txt "$stamp"
fi
# Writes the recordings. Arguments go to `cargo test`, as in tests/run.sh.
rm -rf "$target/tmp/mcap"
cargo test --locked --quiet --test live_recording "$@"
"$venv/bin/python" tests/mcap/read.py "$target/tmp/mcap"
