#!/usr/bin/env bash
# Builds the Python package as pip does and tests it in virtual environments of their own. Needs Rust,
# Python 3.11 or later with venv, Debian's packages and PyPI once. The build shares target/debug with
# cargo's. Arguments go to the build, such as --no-default-features.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/debian.sh
. tests/venv.sh
debian openssl=openssl /usr/sbin/mosquitto=mosquitto
venv python python/tests
wheels=$target/tmp/python
rm -rf "$wheels"
# The profile of the other tests, so that what they have built serves here too.
PATH=$venv/bin:$PATH MATURIN_PEP517_ARGS="--profile dev --locked $*" CARGO_TARGET_DIR=$target \
    "$venv/bin/pip" wheel --quiet --disable-pip-version-check --no-build-isolation --no-deps --wheel-dir "$wheels" ./python
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/*.whl
# Most of the live client's tests wait for the clock, so several run at once. Those over MQTT take a
# program that has it.
cargo build --locked --workspace --features mqtt,ros2 --bin pickline
cp "$target/debug/pickline" "$wheels/pickline-mqtt"
PICKLINE=$venv/bin/pickline PICKLINE_MQTT=$wheels/pickline-mqtt "$python" -m pytest --quiet \
    -p no:cacheprovider --numprocesses 4 --ignore python/tests/sb3 --ignore python/tests/rllib python/tests
# The command, as pip installs it.
"$venv/bin/pickline" --version
bash python/tests/sb3/run.sh "$wheels"/*.whl
bash python/tests/rllib/run.sh "$wheels"/*.whl
