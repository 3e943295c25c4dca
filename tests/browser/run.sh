#!/usr/bin/env bash
# Tests of the pages in headless Chromium. Installs what is missing: Chromium and Node by
# apt-get, the pinned driver from npm into the target folder.
set -euo pipefail
cd "$(dirname "$0")/../.."

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
missing=()
[ -x /usr/bin/chromium ] || missing+=(chromium)
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
if [ ${#missing[@]} -gt 0 ]; then
    as_root apt-get update
    as_root apt-get install --yes --no-install-recommends "${missing[@]}"
fi

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
export MODULES=$target/browser PICKLINE=$target/debug/pickline
mkdir -p "$MODULES"
# Only when what is pinned has changed: so that a machine without a network can test again.
if ! cmp --silent tests/browser/package-lock.json "$MODULES/package-lock.json" ||
    [ ! -d "$MODULES/node_modules/playwright-core" ]; then
    cp tests/browser/package.json tests/browser/package-lock.json "$MODULES/"
    npm ci --prefix "$MODULES" --no-audit --no-fund
fi

cargo build --locked
for test in tests/browser/*.mjs; do
    case $test in */common.mjs) continue ;; esac
    echo "$test"
    node "$test"
done
