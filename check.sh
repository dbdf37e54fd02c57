#!/usr/bin/env bash
# Everything that CI checks, and what a developer runs before a commit: formatting, lints, tests, documentation.
# A fresh Debian or Ubuntu machine with Rust passes it; what else is needed it installs, where it may.
set -euo pipefail
cd "$(dirname "$0")"

step() { printf '\n== %s\n' "$*"; }

# A Vulkan driver: Mesa's lavapipe renders on the processor, so no graphics card is needed. And an emulator of an old processor: the
# same bits must come out there.
have_vulkan() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
    compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null || compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}
have_numpy() { python3 -c 'import numpy' 2>/dev/null; }
missing=()
if [ "$(uname -s)" = Linux ]; then
    have_vulkan || missing+=(mesa-vulkan-drivers)
    # The example of a navigator in Python: numpy from Debian where `python3` is Debian's, else from PyPI (below).
    if ! have_numpy && [ "$(command -v python3)" -ef /usr/bin/python3 ]; then missing+=(python3-numpy); fi
    command -v python3 >/dev/null || missing+=(python3 python3-numpy)
    [ "$(uname -m)" != x86_64 ] || command -v qemu-x86_64 >/dev/null || missing+=(qemu-user)
fi
if [ ${#missing[@]} -gt 0 ]; then
    step "installing ${missing[*]}"
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo -n)
    if command -v apt-get >/dev/null && "${as_root[@]}" true 2>/dev/null; then
        "${as_root[@]}" apt-get update -qq
        DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
    else
        echo "${missing[*]}: not here, and this script may not install it. On Debian or Ubuntu, as root:" >&2
        echo "    apt-get install ${missing[*]}" >&2
        exit 1
    fi
fi
# A python3 of another make (pyenv, conda, a Mac's) does not read Debian's packages: it gets a virtual environment.
if ! have_numpy; then
    environment="${CARGO_TARGET_DIR:-target}"
    mkdir -p "$environment"
    environment="$(cd "$environment" && pwd)/python"
    if [ ! -x "$environment/bin/python3" ] || ! "$environment/bin/python3" -c 'import numpy' 2>/dev/null; then
        step "installing numpy into $environment"
        python3 -m venv --clear "$environment"
        "$environment/bin/python3" -m pip install --quiet --disable-pip-version-check numpy
    fi
    export PATH="$environment/bin:$PATH"
fi
# What lavapipe and other drivers say about a missing desktop does not belong into test output.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"
export RUSTDOCFLAGS="-D warnings"

step "formatting"
cargo fmt --all --check

step "lints"
cargo clippy --release --workspace --all-targets --locked -- -D warnings
cargo clippy --release --locked --no-default-features --lib -- -D warnings

step "tests"
cargo test --release --workspace --locked

step "the documents' examples that read a sweep's results"
DUCTLOOP="${CARGO_TARGET_DIR:-target}/release/ductloop" python3 tests/reading_results.py

step "a navigator in a crate outside the workspace"
# It has a lock file of its own making from the workspace's, so that both stand on the same versions.
cp Cargo.lock examples/own-navigator/Cargo.lock
cargo run --release --quiet --offline --manifest-path examples/own-navigator/Cargo.toml --target-dir target -- scenarios/straight.toml

step "documentation"
cargo doc --release --workspace --no-deps --locked --quiet

step "figures, the small slice"
./figures.sh --slice "$(mktemp -d)/figures.json"

step "all good"
