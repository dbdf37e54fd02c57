#!/usr/bin/env bash
# Sweeps and studies on real engines: Slurm with two virtual nodes on this machine, a Ray cluster of two, an object store that speaks S3; on a
# disk that fills up; and studies that Optuna drives.
#   tests/engines/run.sh           all of it; a node of each engine is killed in mid-sweep
#   tests/engines/run.sh --small   what CI runs: no node of Slurm is killed (its return takes minutes), no S3 (its build takes minutes), no
#                                  Ray (what runs on a killed node outlives it on slow machines)
# What is needed is installed where that may be done: Debian's Slurm, and from PyPI into target/engines. What cannot be had or started here
# for reasons of the machine is skipped, and said so, exit code 0; all else that does not work fails, a hang too. DUCTLOOP names a program
# that is built already, DUCTLOOP_S3 one with the feature s3.
set -euo pipefail
cd "$(dirname "$0")/../.."
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"
target="${CARGO_TARGET_DIR:-$PWD/target}"

small=()
# What one engine's test may take; the tests themselves say what they wait for before that.
limit=1000
case "${1:-}" in
'') ;;
--small)
    small=(--small)
    limit=660
    ;;
*)
    echo "usage: $0 [--small]" >&2
    exit 2
    ;;
esac

step() { printf '\n== engines: %s\n' "$*"; }
passed=() skipped=() failed=()
skip() {
    printf 'skipped: %s: %s\n' "$1" "$2"
    skipped+=("$1")
}
# An engine's name, its test, the test's arguments. The test ends with 77 where the machine does not allow it.
run() {
    local engine=$1 code=0
    shift
    timeout --foreground --kill-after=30 "$limit" "$python" "$@" || code=$?
    case $code in
    0) passed+=("$engine") ;;
    77) skip "$engine" "see above" ;;
    124 | 137)
        printf 'engines: %s: not over within %s s\n' "$engine" "$limit"
        failed+=("$engine")
        ;;
    *) failed+=("$engine") ;;
    esac
}
finish() {
    printf '\nengines: passed: %s; skipped: %s; failed: %s\n' "${passed[*]:-none}" "${skipped[*]:-none}" "${failed[*]:-none}"
    [ ${#failed[@]} -eq 0 ] || exit 1
    exit 0
}

if [ "$(uname -s)" != Linux ] || ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null; then
    skip "all engines" "they are tested on Linux with Python 3.9 or later"
    finish
fi

if [ -z "${DUCTLOOP:-}" ]; then
    step "the program"
    cargo build --release --locked --bin ductloop
    DUCTLOOP="$target/release/ductloop"
fi

slurm() (
    PATH="$PATH:/usr/sbin:/sbin"
    command -v slurmctld && command -v slurmd && command -v sbatch
) >/dev/null
missing=()
slurm || missing+=(slurmctld slurmd slurm-client)
python3 -c 'import ensurepip' 2>/dev/null || missing+=(python3-venv)
as_root=()
[ "$(id -u)" = 0 ] || as_root=(sudo -n)
if [ ${#missing[@]} -gt 0 ] && command -v apt-get >/dev/null && "${as_root[@]}" true 2>/dev/null; then
    step "installing ${missing[*]}"
    quick=(-qq -o Acquire::Retries=1 -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20 -o DPkg::Lock::Timeout=60)
    "${as_root[@]}" timeout 300 apt-get update "${quick[@]}" || true
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive timeout 300 \
        apt-get install -y "${quick[@]}" --no-install-recommends "${missing[@]}" >/dev/null || true
fi

# Python's packages: a virtual environment, since Debian's Python takes none of its own (PEP 668).
venv="$target/engines"
python="$venv/bin/python"
# A package, and the module that it brings.
have() {
    "$python" -c "import $2" 2>/dev/null && return 0
    step "installing $1"
    timeout 400 "$python" -m pip install -q --disable-pip-version-check --retries 2 --timeout 30 "$1" && "$python" -c "import $2"
}
if ! "$python" -c '' 2>/dev/null && ! python3 -m venv --clear "$venv"; then
    skip "all engines" "no virtual environment of Python can be made"
    finish
fi
if ! have pyarrow pyarrow.parquet; then
    skip "all engines" "PyPI's pyarrow, which reads their tables, is not here and cannot be installed"
    finish
fi

step "a full disk"
run "a full disk" tests/engines/full_disk.py "$DUCTLOOP"

if slurm; then
    step "Slurm, $(PATH="$PATH:/usr/sbin:/sbin" slurmctld -V 2>/dev/null || true)"
    run Slurm tests/engines/slurm.py "$DUCTLOOP" "${small[@]}"
else
    skip Slurm "it is not here and cannot be installed (Debian: slurmctld slurmd slurm-client)"
fi

if have optuna optuna; then
    step "Optuna, $("$python" -c 'import optuna; print(optuna.__version__)')"
    run Optuna tests/engines/optuna_study.py "$DUCTLOOP"
else
    skip Optuna "PyPI's optuna is not here and cannot be installed"
fi

if [ ${#small[@]} -gt 0 ]; then
    skip Ray "the small form leaves it out: with a node killed it has ended on quiet machines only"
elif have ray ray; then
    step "Ray, $("$python" -c 'import ray; print(ray.__version__)')"
    run Ray tests/engines/ray_cluster.py "$DUCTLOOP" "${small[@]}"
else
    skip Ray "PyPI's ray is not here and cannot be installed"
fi

if [ ${#small[@]} -gt 0 ]; then
    skip S3 "the small form does not build it"
elif have 'moto[server]' moto.server; then
    step "S3"
    if [ -z "${DUCTLOOP_S3:-}" ]; then
        cargo build --release --locked --bin ductloop --features s3 --target-dir "$target/s3"
        DUCTLOOP_S3="$target/s3/release/ductloop"
    fi
    run S3 tests/engines/s3.py "$DUCTLOOP_S3"
else
    skip S3 "PyPI's moto is not here and cannot be installed"
fi
finish
