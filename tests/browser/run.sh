#!/usr/bin/env bash
# Tests of the pages in headless Chromium. Installs what is missing: Chromium and Node by
# apt-get, the pinned driver from npm into the target folder.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/modules.sh
debian /usr/bin/chromium=chromium
modules browser
PICKLINE=$(realpath -m "${CARGO_TARGET_DIR:-target}")/debug/pickline
export PICKLINE

cargo build --locked --workspace --bin pickline
for test in tests/browser/*.mjs; do
    case $test in */common.mjs) continue ;; esac
    echo "$test"
    node "$test"
done
