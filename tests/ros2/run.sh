#!/usr/bin/env bash
# Tests of the ROS 2 transport, between programs and against Cyclone DDS, another DDS
# implementation, which is installed from PyPI into a venv under the target folder. Only
# the loopback interface is used.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv ros2
PICKLINE_ROS2_PYTHON=$python cargo test --locked --no-default-features \
    --features mqtt,ros2 --test ros2 "$@"
