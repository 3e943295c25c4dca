#!/usr/bin/env bash
# Runs every test. Needs only the Rust toolchain and Python 3; what else a test wants
# is installed here. Arguments go to `cargo test`.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/debian.sh
# Certificates for tests/live/peers/, a clock that is set for tests/live/clock/.
debian openssl=openssl faketime=faketime
# What the tests in Python need is fetched while cargo builds: it takes the network more than a core. What
# fails is tried again, and reported, by the test that needs it.
bash tests/fetch.sh >/dev/null 2>&1 &
fetching=$!
trap 'kill $fetching 2>/dev/null || true' EXIT
# `--workspace` here and in the other tests: then what all of them build has the features that the Python
# package asks of shared crates, and its build finds nearly everything built. It has no Rust tests, so
# cargo builds nothing of it here.
cargo test --locked --workspace "$@"
# The benchmarks' code runs once, so that it cannot rot; `cargo bench` measures.
cargo test --locked --workspace --bench engines --bench passes --bench lookahead --bench bound --bench rl --bench search
wait $fetching || true
# The pages that reports write, in a browser.
bash tests/browser/run.sh
# A live line under load, as fast as it goes: nothing lost, memory flat (docs/live.md).
python3 tests/load/load.py --pickline "${CARGO_TARGET_DIR:-target}/debug/pickline" \
    --clock messages --items 300000
# The same by the clock, seen from outside.
python3 tests/load/latency.py --pickline "${CARGO_TARGET_DIR:-target}/debug/pickline" --seconds 10
# Equilibria against an independent solver, which it installs under target/.
bash tests/gambit/run.sh
# Look-ahead and the bound against the optimum of small lines, by two foreign solvers.
bash tests/optimality/run.sh
# Picks against those of the model as a SimPy program.
bash tests/simpy/run.sh
# Travel times of arms against a trajectory generator.
bash tests/ruckig/run.sh
# Recordings of live runs, read by the mcap package of Python.
bash tests/mcap/run.sh
# The unit and the manual pages, as systemd and groff read them.
bash tests/service/run.sh
# Metrics of a running line, read by the parser of Prometheus' client library.
bash tests/metrics/run.sh
# The live protocol over a real MQTT broker, which it installs.
bash tests/mqtt/run.sh
# The same over ROS 2, also with another DDS implementation, which it installs.
bash tests/ros2/run.sh
# Exported policies, by the checker of the package onnx.
bash tests/onnx/run.sh
# The Python package, built and installed as by pip.
bash python/tests/run.sh
