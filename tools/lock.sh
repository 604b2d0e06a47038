#!/usr/bin/env bash
# Solve environment.lock, versions and hashes for every platform; --upgrade asks for the newest.
set -euo pipefail
cd "$(dirname "$0")/.."
trap 'rm -f environment.lock.part' EXIT
cp environment.lock environment.lock.part
.venv/bin/uv pip compile pyproject.toml --extra all --universal --python-version 3.11 \
  --generate-hashes --no-annotate --no-header --quiet "$@" -o environment.lock.part >/dev/null
# torch and its CUDA packages follow the platform: CPU and GPU builds share a version, not a hash
awk '/^[^ ]/ { kept = /^[a-z0-9]/ && !/^(torch==|nvidia-|cuda-|triton)/ } kept' \
  environment.lock.part >environment.lock
