#!/usr/bin/env bash
# Tests of the ROS 2 transport, between programs and against Cyclone DDS, another DDS
# implementation, which is installed from PyPI into a venv under the target folder. Needs
# Python 3 with venv, and the network once. Only the loopback interface is used.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
venv=$target/ros2-venv
stamp=$venv/installed.txt
fail() {
    echo "tests/ros2/run.sh: $1" >&2
    echo "  cure: $2" >&2
    exit 1
}
if ! cmp --silent tests/ros2/requirements.txt "$stamp"; then
    python3 -m venv --clear "$venv" ||
        fail "python3 -m venv failed" "install Python 3 with venv (Debian: apt install python3-venv)"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
        --requirement tests/ros2/requirements.txt ||
        fail "cyclonedds could not be installed from PyPI" \
            "give this machine access to PyPI once (it is kept in $venv)"
    cp tests/ros2/requirements.txt "$stamp"
fi
PICKLINE_ROS2_PYTHON=$venv/bin/python cargo test --locked --no-default-features \
    --features mqtt,ros2 --test ros2 "$@"
