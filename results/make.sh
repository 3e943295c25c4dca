#!/usr/bin/env bash
# Makes the committed results again: results/optimize/*.txt, what `pickline optimize`
# prints for 2, 3 and 4 robots, results/compare/, the paper's comparison,
# results/lookahead/, what planning ahead gains and the certified bound, and
# results/sweep/, the belt speed sweep, all on the paper's two stations, and results/sb3/compare/, the
# policies of both trainers on the paper's cases; then
# results/real-lines/, the stations `delta` and `sorting` at three belt speeds,
# results/failures/, what it gains to foresee failed grasps, and results/single-arm/, one delta or
# SCARA arm, which take an hour. A first
# argument names another folder to write to; PICKLINE names another program than the release
# build; PARTS names what to make, "paper lookahead real-lines failures single-arm" if it is not set.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${1:-results}")
if [ -z "${PICKLINE:-}" ]; then
    cargo build --release --quiet
    PICKLINE=${CARGO_TARGET_DIR:-target}/release/pickline
fi
parts=" ${PARTS:-paper lookahead real-lines failures single-arm} "

# Compares into a folder, of which only the table, the rates and the runs are kept.
compare_into() {
    local folder=$1 all
    shift
    all=$(mktemp -d)
    mkdir -p "$folder"
    "$PICKLINE" compare --quiet "$@" --out "$all" > "$folder/table.txt"
    mv "$all/picking_rate.csv" "$all/runs.csv" "$folder"
    rm -r "$all"
}

# Sets `train`: what a station of the paper is called with.
train_on() {
    train=()
    # The narrow station was fitted with 50 items a pattern.
    if [ "$1" = paper-narrow ]; then train=(--station paper-narrow --train-items 50); fi
}

if [[ $parts = *" paper "* ]]; then
mkdir -p "$out/optimize"
for robots in 2 3 4; do
    "$PICKLINE" optimize --quiet --robots $robots > "$out/optimize/paper-$robots.txt"
    "$PICKLINE" optimize --quiet --station paper-narrow --items 50 --robots $robots \
        > "$out/optimize/paper-narrow-$robots.txt"
done
for station in paper paper-narrow; do
    train_on $station
    for cases in paper dense; do
        mkdir -p "$out/compare/$station-$cases"
        "$PICKLINE" compare --quiet --force --paper --cases $cases "${train[@]}" \
            --svg "$out/compare/$station-$cases/rate.svg" \
            --out "$out/compare/$station-$cases" > "$out/compare/$station-$cases/table.txt"
    done
    mkdir -p "$out/sweep/$station"
    "$PICKLINE" sweep --quiet --force "${train[@]}" --strategy SPT,SPT --out "$out/sweep/$station" \
        --svg "$out/sweep/$station/picked.svg" > "$out/sweep/$station/table.txt"
done
policies=()
for policy in {sb3,native}-{1,2,3}; do
    policies+=(--strategy "onnx:results/sb3/$policy.onnx")
done
compare_into "$out/sb3/compare" --paper --no-bound "${policies[@]}"
fi

if [[ $parts = *" lookahead "* ]]; then
for station in paper paper-narrow; do
    train_on $station
    mkdir -p "$out/lookahead/$station"
    "$PICKLINE" compare --quiet --force --cases all --strategy lookahead \
        --train-patterns balanced "${train[@]}" \
        --svg "$out/lookahead/$station/rate.svg" \
        --out "$out/lookahead/$station" > "$out/lookahead/$station/table.txt"
done
fi

# A line of the station `sorting` carries these.
sorted_waste=(--classes pet:0.3,hdpe:0.3,paper:0.2,wood:0.2)
if [[ $parts = *" real-lines "* ]]; then
    for speed in 0.3 0.4 0.5; do
        line=(--belt-speed $speed --cases results/real-lines/delta.toml --strategy lookahead)
        compare_into "$out/real-lines/delta-$speed" --station delta "${line[@]}"
        compare_into "$out/real-lines/delta-$speed-constant" --no-policy \
            --station results/real-lines/delta-constant.toml "${line[@]}"
    done
    for speed in 0.2 0.3 0.4; do
        line=(--belt-speed $speed --cases results/real-lines/sorting.toml "${sorted_waste[@]}"
            --strategy lookahead)
        compare_into "$out/real-lines/sorting-$speed" --station sorting "${line[@]}"
        compare_into "$out/real-lines/sorting-$speed-constant" --no-policy \
            --station results/real-lines/sorting-constant.toml "${line[@]}"
    done
fi

if [[ $parts = *" failures "* ]]; then
    for station in paper paper-narrow delta sorting; do
        rules=SPT,FIFO
        classes=()
        case $station in
            delta) rules=SPT,SPT,FIFO ;;
            sorting) rules=SPT,SPT,SPT,FIFO classes=("${sorted_waste[@]}") ;;
        esac
        for success in 0.8 0.5; do
            compare_into "$out/failures/$station-$success" --station $station \
                --cases "results/failures/${station/-narrow/}.toml" "${classes[@]}" \
                --grasp-success $success --robust $rules --no-greedy --no-bound \
                --strategy lookahead:foresee=no --strategy lookahead \
                --reference lookahead:foresee=no
        done
    done
fi

if [[ $parts = *" single-arm "* ]]; then
    for arm in delta scara; do
        compare_into "$out/single-arm/$arm" --station "results/single-arm/$arm.toml" \
            --cases "results/single-arm/$arm-cases.toml" --robust FIFO --no-policy --strategy SPT \
            --strategy lookahead
    done
fi
