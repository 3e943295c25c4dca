# Sourced by the tests that need packages from PyPI, in the project's folder: `venv NAME [FOLDER]`
# makes target/NAME-venv what FOLDER/requirements.txt (tests/NAME if not given) says, unless it is
# already, and sets `target`, `venv` and `python`. Needs Python 3.11 or later with venv, and the network
# once; says so when they are missing.

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")

fail() {
    echo "$folder/run.sh: $1" >&2
    echo "  cure: $2" >&2
    exit 1
}

venv() {
    folder=${2:-tests/$1}
    venv=$target/$1-venv
    python=$venv/bin/python
    local wanted=$folder/requirements.txt
    # Only when what is pinned has changed: so that a machine without a network can test again.
    if ! cmp --silent "$wanted" "$venv/installed.txt"; then
        python3 -m venv --clear "$venv" ||
            fail "python3 -m venv failed" "install Python 3.11 or later with venv (Debian: apt install python3-venv)"
        "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
            --requirement "$wanted" ||
            fail "what $wanted names could not be installed from PyPI" \
                "give this machine access to PyPI once (it is kept in $venv) and Python 3.11 or later"
        cp "$wanted" "$venv/installed.txt"
    fi
}
