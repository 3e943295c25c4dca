# Sourced by the tests that need packages from npm, in the project's folder: `modules NAME`
# makes target/NAME what tests/NAME/package-lock.json says, unless it is already, and sets
# MODULES. Installs Node by apt-get when it is missing.

. tests/debian.sh

modules() {
    local wanted=tests/$1/package-lock.json
    debian node=nodejs npm=npm
    MODULES=$(realpath -m "${CARGO_TARGET_DIR:-target}")/$1
    export MODULES
    mkdir -p "$MODULES"
    # Only when what is pinned has changed: so that a machine without a network can test again.
    if ! cmp --silent "$wanted" "$MODULES/installed.json"; then
        cp "tests/$1/package.json" "$wanted" "$MODULES/"
        npm ci --prefix "$MODULES" --no-audit --no-fund
        cp "$wanted" "$MODULES/installed.json"
    fi
}
