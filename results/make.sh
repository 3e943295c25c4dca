#!/usr/bin/env bash
# Makes the committed results again: results/optimize/*.txt, what `pickline optimize`
# prints for 2, 3 and 4 robots, results/compare/, the paper's comparison,
# results/lookahead/, what planning ahead gains and the certified bound, and
# results/sweep/, the belt speed sweep, all on both built-in stations. A first argument
# names another folder to write to; PICKLINE names another program than the release build.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${1:-results}")
if [ -z "${PICKLINE:-}" ]; then
    cargo build --release --quiet
    PICKLINE=${CARGO_TARGET_DIR:-target}/release/pickline
fi
mkdir -p "$out/optimize"
for robots in 2 3 4; do
    "$PICKLINE" optimize --quiet --robots $robots > "$out/optimize/paper-$robots.txt"
    "$PICKLINE" optimize --quiet --station paper-narrow --items 50 --robots $robots \
        > "$out/optimize/paper-narrow-$robots.txt"
done
for station in paper paper-narrow; do
    # The narrow station was fitted with 50 items a pattern.
    train=()
    if [ $station = paper-narrow ]; then train=(--station $station --train-items 50); fi
    for cases in paper dense; do
        mkdir -p "$out/compare/$station-$cases"
        "$PICKLINE" compare --quiet --force --paper --cases $cases "${train[@]}" \
            --svg "$out/compare/$station-$cases/rate.svg" \
            --out "$out/compare/$station-$cases" > "$out/compare/$station-$cases/table.txt"
    done
    mkdir -p "$out/lookahead/$station"
    "$PICKLINE" compare --quiet --force --cases all --strategy lookahead \
        --train-patterns balanced "${train[@]}" \
        --svg "$out/lookahead/$station/rate.svg" \
        --out "$out/lookahead/$station" > "$out/lookahead/$station/table.txt"
    mkdir -p "$out/sweep/$station"
    "$PICKLINE" sweep --quiet --force "${train[@]}" --strategy SPT,SPT --out "$out/sweep/$station" \
        --svg "$out/sweep/$station/picked.svg" > "$out/sweep/$station/table.txt"
done
