#!/usr/bin/env bash
# Build the compared chapters of the ci profile and run the tests as on other machines, each in its
# own process:   tools/machines.sh [MACHINE...]
# Without names: all machines below that this processor can imitate. TESTS are the arguments of
# pytest; without them all tests that are not slow, but for those that no processor can change.
set -uo pipefail
cd "$(dirname "$0")/.."

NAMES="oldest haswell zen skylake mixed host"
TESTS=${TESTS:-"-m 'not slow' --ignore=tests/hostile --ignore=tests/reader --ignore=tests/test_wheel.py
  --ignore=tests/test_house.py --ignore=tests/book/test_book.py"}

flag_of() { # what a machine needs of the processor
  case $1 in oldest | host) echo sse4_2 ;; skylake) echo avx512dq ;; *) echo avx2 ;; esac
}

two_threads() { export OMP_NUM_THREADS=2 OPENBLAS_NUM_THREADS=2 NUMBA_NUM_THREADS=2; }
no_avx512() { export NPY_DISABLE_CPU_FEATURES="X86_V4 AVX512_ICL AVX512_SPR"; }
no_avx() { export NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL AVX512_SPR"; }
# kernels of OpenBLAS, processor of Numba, vectors of ATen and those of oneDNN, if it is told
compute_as() {
  export OPENBLAS_CORETYPE=$1 NUMBA_CPU_NAME=$2 NUMBA_CPU_FEATURES="" ATEN_CPU_CAPABILITY=$3
  [ -z "${4:-}" ] || export ONEDNN_MAX_CPU_ISA=$4
}

imitate() { # the variables by which each library computes as on a machine
  unset OPENBLAS_CORETYPE
  case $1 in
  oldest) no_avx; two_threads; compute_as Prescott generic default SSE41 ;; # vectors of 128 bits
  haswell) no_avx512; compute_as Haswell haswell avx2 AVX2 ;;
  zen) no_avx512; two_threads; compute_as Zen znver2 avx2 ;;
  skylake) compute_as SkylakeX skylake-avx512 avx512 AVX512_CORE ;;
  mixed) no_avx; compute_as Haswell generic default ;; # one library knows the processor, one not
  host) two_threads ;;
  esac
}

passes() { # build and test as on a machine; both print
  local build=build/machines/$1 results
  imitate "$1"
  results=$(sed -nE "s|^ \"([0-9]+_[a-z_]+)/.*|$build/results/\1|p" tests/reference/numbers.json | sort -u)
  export CMTOF_RESULTS=$PWD/$build/results
  # shellcheck disable=SC2086 # one name a chapter
  .venv/bin/snakemake --nolock --quiet all --cores "$(nproc)" --rerun-incomplete \
    --config profile=ci "build=$build" -- $results &&
    xargs .venv/bin/python -m pytest <<<"$TESTS"
}

possible=
for name in $NAMES; do
  if grep -qw "$(flag_of "$name")" /proc/cpuinfo 2>/dev/null; then possible+="$name "; fi
done
for name in ${*:-${possible:-none}}; do
  if [[ " $NAMES " != *" $name "* ]]; then
    echo "Expected some of ${possible% }, got $name. Choose among those." >&2
    exit 2
  fi
done
failed=0
for name in ${*:-$possible}; do
  started=$SECONDS said=PASS
  (passes "$name") || { said=FAIL failed=1; }
  echo "$said  $name: $((SECONDS - started)) s"
done
exit $failed
