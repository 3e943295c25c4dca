#!/usr/bin/env bash
# Tests of the MQTT transport against mosquitto, which is installed by apt-get when it is
# missing. Each test starts a broker of its own on a free port of the loopback interface.
set -euo pipefail
cd "$(dirname "$0")/../.."

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
missing=()
[ -x /usr/sbin/mosquitto ] || missing+=(mosquitto)
command -v mosquitto_sub >/dev/null || missing+=(mosquitto-clients)
command -v openssl >/dev/null || missing+=(openssl)
if [ ${#missing[@]} -gt 0 ]; then
    as_root apt-get update
    as_root apt-get install --yes --no-install-recommends "${missing[@]}"
fi

cargo test --locked --no-default-features --features mqtt,ros2 --test mqtt "$@"
