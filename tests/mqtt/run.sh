#!/usr/bin/env bash
# Tests of the MQTT transport against mosquitto, which is installed by apt-get when it is
# missing. Each test starts a broker of its own on a free port of the loopback interface.
# Then load over such a broker, as fast as it goes: nothing lost (docs/live.md).
set -euo pipefail
cd "$(dirname "$0")/../.."

. tests/debian.sh
debian /usr/sbin/mosquitto=mosquitto mosquitto_sub=mosquitto-clients openssl=openssl

# The same build as in tests/ros2/ and python/tests/.
cargo test --locked --workspace --features mqtt,ros2 --test mqtt "$@"
python3 tests/load/load.py --mqtt --pickline "${CARGO_TARGET_DIR:-target}/debug/pickline" \
    --clock messages --items 100000
