#!/bin/sh
# The Python module's tests: makes a wheel, installs it where there is neither a Rust toolchain nor a compiler, and runs tests/python.
# Usage: python.sh [WHEEL]. Without a wheel, one is made of the development profile, as quickly as can be: with the system's PROJ.
set -eu
cd "$(dirname "$0")/.."
root=$(pwd)
. scripts/apt.sh
. scripts/tools.sh
. scripts/skipped.sh
CARGO=${CARGO:-cargo}
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target"
target=$(realpath "$target")
export CARGO_TARGET_DIR="$target"
wheel=${1:-}
environment=$target/python

tools_in "$target/python-tools" maturin==1.16.0 abi3audit==0.0.26 || {
    skipped "tests/python" "python3 with venv and PyPI are needed"
    exit 0
}
if [ -z "$wheel" ]; then
    rm -rf "$target/wheel"
    "$target/python-tools/bin/maturin" build --quiet --locked --profile dev --compatibility linux \
        --manifest-path python/Cargo.toml --out "$target/wheel"
    wheel=$(ls "$target"/wheel/*.whl)
fi
"$target/python-tools/bin/abi3audit" --strict "$wheel"

rm -rf "$environment"
python3 -m venv "$environment"
# Neither cargo nor a compiler is on this path: a wheel needs none.
start=$(date +%s)
env -i HOME="$HOME" PATH="$environment/bin" "$environment/bin/pip" install --quiet --disable-pip-version-check --no-index "$wheel"
echo "$(basename "$wheel"): $(wc -c <"$wheel" | awk '{ printf "%.1f", $1 / 1e6 }') MB, installed in $(($(date +%s) - start)) s"
"$environment/bin/pip" install --quiet --disable-pip-version-check pytest==8.4.2 mypy==2.4.1
# Spark is large: it is installed once, and lent to each new environment.
java -version >/dev/null 2>&1 || apt_install default-jre-headless || echo "there is no Java for Spark" >&2
if tools_in "$target/python-spark" pyspark==4.0.1 pandas==2.3.3 pyarrow==21.0.0 fsspec==2025.9.0; then
    packages='import sysconfig; print(sysconfig.get_path("purelib"))'
    "$target/python-spark/bin/python" -c "$packages" >"$("$environment/bin/python" -c "$packages")/spark.pth"
    # From where no folder is called as the package is.
    (cd / && "$environment/bin/python" -m mypy.stubtest lanewright)
else
    skipped "mypy.stubtest lanewright" "Spark's packages and PyPI are needed"
fi
$CARGO build --quiet --locked
LANEWRIGHT_PROGRAM=${LANEWRIGHT_PROGRAM:-$target/debug/lanewright} "$environment/bin/python" -m pytest -q -p no:cacheprovider tests/python
