#!/usr/bin/env bash
# Tests of the ROS 2 transport, between programs and against Cyclone DDS, another DDS
# implementation, which is installed from PyPI into a venv under the target folder; only
# the loopback interface is used. The interface package is built as in any workspace, with
# colcon and ROS's code generators from Debian.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/venv.sh
venv ros2
. tests/ros2/build.sh
PICKLINE_ROS2_FIELDS=$fields PICKLINE_ROS2_PYTHON=$python cargo test --locked --workspace \
    --features mqtt,ros2 --test ros2 "$@"
