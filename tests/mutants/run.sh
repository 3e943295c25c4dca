#!/usr/bin/env bash
# Runs the tests against mutants of the code: hours, and so no part of .ci/run. Installs
# cargo-mutants under target/. Arguments: `bash tests/mutants/run.sh --help`.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
export PATH="$target/mutants/tools/bin:$PATH"
if [[ $(cargo mutants --version 2>/dev/null) != "cargo-mutants 27.1.0" ]]; then
    CARGO_TARGET_DIR="$target/mutants/tools/build" cargo install --locked --quiet \
        --root "$target/mutants/tools" cargo-mutants@27.1.0
fi
exec python3 tests/mutants/run.py "$@"
