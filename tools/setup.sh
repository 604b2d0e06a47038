#!/usr/bin/env bash
# Make .venv from environment.lock, and the system libraries that it needs. Called by make; a call
# with nothing to do returns at once. Needs Python 3.11 or newer.
set -euo pipefail
cd "$(dirname "$0")/.."

VENV=.venv
STAMP=$VENV/cmtof.stamp

say() { printf '%s\n' "$*" >&2; }
die() { say "setup: $*"; exit 1; }

# The stamp holds what the environment was made from, and where: a moved folder breaks a venv.
key() { { cat environment.lock pyproject.toml; pwd -P; } | sha256sum | cut -d ' ' -f 1; }

if [ -f "$STAMP" ] && [ "$(cat "$STAMP")" = "$(key)" ] && [ -x "$VENV/bin/python" ]; then
  exit 0
fi

is_root() { [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; }

apt_install() {
  say "setup: installing $* with apt-get"
  { apt-get update -qq && DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends "$@"; } </dev/null >/dev/null
}

find_python() {
  local name
  for name in python3.11 python3 python3.12 python3.13; do
    if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      "$name" -c 'import sys; print(sys.executable)'
      return
    fi
  done
  die "Expected Python 3.11 or newer, found none. Install it (Debian, Ubuntu: apt-get install python3.11)."
}

make_venv() {
  local python=$1 package
  if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    package=$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')
    is_root || die "Expected Python's venv module, found none. Install it: sudo apt-get install $package"
    apt_install "$package"
  fi
  say "setup: making $VENV with $("$python" --version)"
  "$python" -m venv --clear "$VENV"
}

# VTK, which draws the three-dimensional scenes, loads these even without a screen.
graphics_libraries() {
  if "$VENV/bin/python" -c 'import ctypes; [ctypes.CDLL(n) for n in ("libEGL.so.1", "libGL.so.1")]' \
      2>/dev/null; then
    return
  fi
  if [ "$(uname)" != Linux ]; then
    return
  elif is_root && apt_install libegl1 libgl1; then
    return
  fi
  say "setup: libEGL.so.1 or libGL.so.1 is missing; three-dimensional views need them:" \
    "sudo apt-get install --no-install-recommends libegl1 libgl1"
}

rm -f "$STAMP"
# an environment that is whole is brought up to date, another one is made anew
if ! { [ -x "$VENV/bin/pip" ] && "$VENV/bin/python" -c \
    'import os, sys; sys.exit(os.path.realpath(sys.prefix) != os.path.realpath(sys.argv[1]))' "$VENV" \
    2>/dev/null && "$VENV/bin/pip" --version >/dev/null 2>&1; }; then
  python=$(find_python)
  make_venv "$python"
fi
say "setup: installing the packages of environment.lock (the first time takes minutes)"
pip=("$VENV/bin/python" -m pip install -qq --disable-pip-version-check)
"${pip[@]}" --no-deps --require-hashes -r environment.lock
"${pip[@]}" --no-build-isolation -e '.[train]' # adds the platform's build of torch
graphics_libraries
key >"$STAMP.part"
mv "$STAMP.part" "$STAMP"
say "setup: done"
