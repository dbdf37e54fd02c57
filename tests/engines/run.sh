#!/usr/bin/env bash
# Sweeps on real engines: Slurm with two virtual nodes on this machine, a Ray cluster of two, an object store that speaks S3.
#   tests/engines/run.sh           all of it; a node of each engine is killed in mid-sweep
#   tests/engines/run.sh --small   what CI runs: no node of Slurm is killed (its return takes minutes), no S3 (its build takes minutes)
# What is needed is installed where that may be done: Debian's Slurm, and from PyPI into target/engines. What cannot be had is skipped, and
# said so. DUCTLOOP names a program that is built already, DUCTLOOP_S3 one with the feature s3.
set -euo pipefail
cd "$(dirname "$0")/../.."
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"

small=()
case "${1:-}" in
'') ;;
--small) small=(--small) ;;
*)
    echo "usage: $0 [--small]" >&2
    exit 2
    ;;
esac

step() { printf '\n== engines: %s\n' "$*"; }
skipped() { printf 'skipped: %s\n' "$*"; }

if [ "$(uname -s)" != Linux ] || ! command -v python3 >/dev/null; then
    skipped "engines are tested on Linux with Python 3"
    exit 0
fi

if [ -z "${DUCTLOOP:-}" ]; then
    step "the program"
    cargo build --release --locked --bin ductloop
    DUCTLOOP="$PWD/target/release/ductloop"
fi

slurm() { command -v slurmctld >/dev/null && command -v slurmd >/dev/null && command -v sbatch >/dev/null; }
as_root=()
[ "$(id -u)" = 0 ] || as_root=(sudo -n)
if ! slurm && command -v apt-get >/dev/null && "${as_root[@]}" true 2>/dev/null; then
    step "installing slurmctld slurmd slurm-client"
    "${as_root[@]}" apt-get update -qq || true
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends slurmctld slurmd slurm-client \
        >/dev/null || true
fi

# Python's packages: a virtual environment, since Debian's Python takes none of its own (PEP 668).
venv="$PWD/target/engines"
wanted=(pyarrow ray 'moto[server]')
[ ${#small[@]} -eq 0 ] || wanted=(pyarrow ray)
modules='pyarrow, ray'
[ ${#small[@]} -gt 0 ] || modules='pyarrow, ray, moto'
if ! "$venv/bin/python" -c "import $modules" 2>/dev/null; then
    step "installing ${wanted[*]}"
    if ! { python3 -m venv "$venv" && "$venv/bin/pip" install -q --disable-pip-version-check "${wanted[@]}"; }; then
        skipped "no virtual environment with ${wanted[*]}: tables cannot be read, Ray cannot be had"
        exit 0
    fi
fi

failed=()
if slurm; then
    step "Slurm, $(sbatch --version)"
    "$venv/bin/python" tests/engines/slurm.py "$DUCTLOOP" "${small[@]}" || failed+=(Slurm)
else
    skipped "Slurm is not here and cannot be installed (Debian: slurmctld slurmd slurm-client)"
fi

step "Ray, $("$venv/bin/python" -c 'import ray; print(ray.__version__)')"
"$venv/bin/python" tests/engines/ray_cluster.py "$DUCTLOOP" "${small[@]}" || failed+=(Ray)

if [ ${#small[@]} -eq 0 ]; then
    step "S3"
    if [ -z "${DUCTLOOP_S3:-}" ]; then
        cargo build --release --locked --bin ductloop --features s3 --target-dir target/s3
        DUCTLOOP_S3="$PWD/target/s3/release/ductloop"
    fi
    "$venv/bin/python" tests/engines/s3.py "$DUCTLOOP_S3" || failed+=(S3)
else
    skipped "S3 (the small form does not build it)"
fi

if [ ${#failed[@]} -gt 0 ]; then
    printf '\nengines: FAILED: %s\n' "${failed[*]}"
    exit 1
fi
printf '\nengines: all good\n'
