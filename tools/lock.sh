#!/usr/bin/env bash
# Write environment.lock anew: exact versions for every platform and Python from 3.11 on.
set -euo pipefail
cd "$(dirname "$0")/.."
trap 'rm -f environment.lock.part' EXIT

# The CUDA packages follow from the platform's own torch, and a local tag such as +cpu names a wheel
# that other machines cannot find; one plain line serves them all.
.venv/bin/uv pip compile pyproject.toml --extra all --universal --python-version 3.11 \
  --no-annotate --no-header --quiet |
  sed -E 's/^(torch==[0-9.]+)(\+[a-z0-9.]+)?( *;.*)?$/\1/' |
  grep -vE '^(nvidia-|cuda-|triton)' | grep -vE '^--' |
  awk '!seen[$0]++' >environment.lock.part
grep -qE '^torch==' environment.lock.part
mv environment.lock.part environment.lock
