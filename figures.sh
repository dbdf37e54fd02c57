#!/usr/bin/env bash
# Repeats every measured figure that the documents quote, and writes them as one JSON document.
#
#   ./figures.sh [--slice] [OUT.json]      (figures.json)
#
# Eight seeds a scenario, 32 random networks, the whole accuracy studies and those of tuning; hours on two cores without a graphics card.
# --slice takes one seed, four random networks, fewer frames and the smallest study: some minutes. A hundred networks are a sweep of their own:
#   ductloop sweep scenarios/sweeps/random-networks.toml
set -euo pipefail
cd "$(dirname "$0")"

slice=()
tuning=(koh-cho pure-pursuit lqr wheel-controller perception estimator)
poses=()
frames=10000
out=figures.json
for argument in "$@"; do
    case "$argument" in
        --slice) slice=(--slice); tuning=(smoke); poses=(--set poses.count=4); frames=600 ;;
        -*) echo "figures.sh: unknown option $argument; usage: ./figures.sh [--slice] [OUT.json]" >&2; exit 2 ;;
        *) out=$argument ;;
    esac
done

parts=$(mktemp -d)
trap 'rm -rf "$parts"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$parts}"

echo "physics …" >&2
cargo test --release --locked -p ductloop-sim --test turning --test centre_of_mass --test yaw_torque --test wheel_shapes --test slope \
    --test step_response --test energy --test time_step --test disturbance --test give_and_play --test drive --test contact \
    -- --nocapture --test-threads 1 >"$parts/physics"
echo "stripes …" >&2
cargo test --release --locked --workspace --test stripes -- --nocapture --test-threads 1 >"$parts/stripes"
echo "sensor …" >&2
cargo test --release --locked -p ductloop-sensor --test emva --test stripe_physics --test centres --test agreement -- --nocapture --test-threads 1 >"$parts/sensor"
echo "memory …" >&2
cargo run --release --locked --quiet -p ductloop-sensor --example resident_memory "$frames" >"$parts/memory"
echo "calibration …" >&2
cargo test --release --locked -p ductloop --test calibration --test real_photographs -- --nocapture --test-threads 1 >"$parts/calibration"
for study in accuracy accuracy-noise accuracy-everything accuracy-hard; do
    echo "$study …" >&2
    # A study whose bounds do not hold exits with 1 and has its figures all the same.
    cargo run --release --locked --quiet -- accuracy "scenarios/studies/$study.toml" --out "$parts/studies" --json --quiet \
        ${poses[@]+"${poses[@]}"} >"$parts/$study.json" || [ $? = 1 ]
done
tuned=()
for study in "${tuning[@]}"; do
    echo "tune $study …" >&2
    cargo run --release --locked --quiet -- tune "scenarios/studies/$study.toml" --out "$parts/tuned" --json --quiet >"$parts/tuned-$study.json"
    tuned+=(--tuned "$parts/tuned-$study.json")
done
echo "bench …" >&2
cargo run --release --locked --quiet -- bench --json >"$parts/bench"
echo "runs …" >&2
cargo run --release --locked --quiet --example figures -- ${slice[@]+"${slice[@]}"} \
    --bench "$parts/bench" --physics "$parts/physics" --stripes "$parts/stripes" \
    --sensor "$parts/sensor" --memory "$parts/memory" --calibration "$parts/calibration" \
    --study "$parts/accuracy.json" --study "$parts/accuracy-noise.json" --study "$parts/accuracy-everything.json" \
    --study "$parts/accuracy-hard.json" "${tuned[@]}" "$out"
