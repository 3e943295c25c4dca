#!/usr/bin/env bash
# The installed unit as systemd reads it, and the manual pages as groff does, both without a
# word of warning.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/debian.sh
debian systemd-analyze=systemd groff=groff-base
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
# Arguments go to `cargo build`.
cargo build --locked --quiet --workspace --bin pickline "$@"
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
"$target/debug/pickline" service install --root "$root" --prefix /usr > "$root/said"
# Units are looked up, and their programs, below the root; those of systemd itself are
# stood in for.
for target_unit in sysinit basic shutdown multi-user network-online; do
    printf '[Unit]\nDescription=%s\n' "$target_unit" \
        > "$root/usr/lib/systemd/system/$target_unit.target"
done
verify() {
    systemd-analyze verify --root="$root" --man=no pickline@line1.service 2>&1
}
if ! said=$(verify) || [ -n "$said" ]; then
    echo "systemd-analyze verify: $said" >&2
    exit 1
fi
# It does look: a slip is found.
sed -i 's/^WatchdogSec=/WatchdogSecs=/' "$root/usr/lib/systemd/system/pickline@.service"
said=$(verify || true)
if [[ "$said" != *"Unknown key"*WatchdogSecs* ]]; then
    echo "systemd-analyze verify does not see a wrong key" >&2
    exit 1
fi
pages=0
for page in "$root"/usr/share/man/man1/*.1; do
    said=$(groff -man -Tutf8 -ww -z "$page" 2>&1)
    if [ -n "$said" ]; then
        echo "groff: $page: $said" >&2
        exit 1
    fi
    pages=$((pages + 1))
done
echo "service: the unit and $pages manual pages are well formed"
