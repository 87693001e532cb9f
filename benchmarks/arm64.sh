#!/usr/bin/env bash
# Compare fingerprints of presets on ARM64 with the recorded ones, by emulation on Debian.
#
#   benchmarks/arm64.sh [--set NAME] [PRESET …]     arguments of tests/evolution/fingerprints.py
#
# Needs root for Debian's packages (qemu-user, debootstrap). The first call takes about four minutes
# to set up a folder of about 1.5 GB, $ARM64_FOLDER or ~/.cache/gaitsim-arm64; later calls reuse it.
# A preset takes 1 to 10 minutes.
set -euo pipefail
project=$(realpath "$(dirname "$0")/..")
folder=${ARM64_FOLDER:-${XDG_CACHE_HOME:-$HOME/.cache}/gaitsim-arm64}
root=$folder/root site=$folder/site wheels=$folder/wheels
mkdir -p "$site" "$wheels"

if [ ! -x "$root/usr/bin/python3.11" ]; then
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends qemu-user-static debootstrap unzip
    # Packages are only extracted, so neither a kernel module nor a chroot is needed.
    debootstrap --arch=arm64 --variant=minbase --foreign --include=python3,ca-certificates \
        bookworm "$root"
    for package in "$root"/var/cache/apt/archives/*.deb; do dpkg -x "$package" "$root"; done
fi
if [ ! -d "$site/numpy" ]; then
    mapfile -t needed < <(python3 -c '
import sys, tomllib
print(*tomllib.load(open(sys.argv[1], "rb"))["project"]["dependencies"], sep="\n")' \
        "$project/pyproject.toml")
    platforms=(manylinux_2_28 manylinux_2_27 manylinux_2_17 manylinux2014)
    platforms=("${platforms[@]/%/_aarch64}")
    pip download -q "${platforms[@]/#/--platform=}" --only-binary=:all: \
        --python-version 3.11 --implementation cp --abi cp311 --abi abi3 --abi none \
        -d "$wheels" "${needed[@]}"
    for wheel in "$wheels"/*.whl; do unzip -qo "$wheel" -d "$site"; done
fi
# The project itself is installed anew each time.
rm -rf "$folder"/own "$site"/gaitsim*
pip wheel -q --no-deps -w "$folder/own" "$project"
unzip -qo "$folder"/own/*.whl -d "$site"

PYTHONPATH=$site NUMBA_CACHE_DIR=$folder/compiled exec qemu-aarch64-static -L "$root" \
    "$root/usr/bin/python3.11" "$project/tests/evolution/fingerprints.py" "$@"
