# Sourced by the tests that need packages of Debian: `debian COMMAND=PACKAGE ...` installs
# by apt-get the packages whose command, or file, is missing.

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

debian() {
    local missing=() pair
    for pair in "$@"; do
        command -v "${pair%%=*}" >/dev/null || [ -e "${pair%%=*}" ] || missing+=("${pair##*=}")
    done
    if [ ${#missing[@]} -gt 0 ]; then
        as_root apt-get update
        as_root apt-get install --yes --no-install-recommends "${missing[@]}"
    fi
}
