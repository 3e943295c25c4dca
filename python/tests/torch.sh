# Sourced by the tests that need torch, in the project's folder: `torch_venv NAME [OPTION ...]` makes
# target/python-NAME-venv on Debian's Python and torch, with what python/tests/NAME/requirements.txt says
# (`torch_packages` does only this) and the wheel `wheel`, and sets `venv`. PyPI has no torch without CUDA,
# which is 3 GB. The options are pip's.
. tests/debian.sh

torch_packages() {
    local target wanted=python/tests/$1/requirements.txt
    target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
    venv=$target/python-$1-venv
    debian /usr/lib/python3/dist-packages/torch=python3-torch
    if ! cmp --silent "$wanted" "$venv/installed.txt"; then
        /usr/bin/python3 -m venv --clear --system-site-packages "$venv"
        # Without their dependencies: they would bring another torch.
        "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --only-binary=:all: \
            "${@:2}" --requirement "$wanted"
        cp "$wanted" "$venv/installed.txt"
    fi
}

torch_venv() {
    torch_packages "$@"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheel"
}
