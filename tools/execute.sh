#!/usr/bin/env bash
# Run one notebook apart from everything else: tools/execute.sh SCRIPT PARAMETERS WORK RESULT FOLDER
# This Python, few threads, nobody's start-up. RESULT, the executed notebook, and FOLDER, its figures
# and checks, appear when they are whole; what a failed run leaves lies in WORK with its log.
set -euo pipefail

script=$1 parameters=$2 work=$(realpath -m "$3") result=$4 folder=$5
rm -rf "$work"
mkdir -p "$work"/results "$work"/ipython/profile_default
# the kernel's remarks on its own workings, and a grammar that takes seconds, are left out
cp configs/ipython_kernel_config.json "$work"/ipython/profile_default
export CMTOF_OUTPUT=$work/results IPYTHONDIR=$work/ipython PYTHONHASHSEED=0
export JUPYTER_PATH="" JUPYTER_PREFER_ENV_PATH=1 PYDEVD_DISABLE_FILE_VALIDATION=1
export CI=1 # nobody waits: no progress bars, no word on compiling
export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
export NUMBA_NUM_THREADS=${NUMBA_NUM_THREADS:-1}
.venv/bin/python -m cmtof_book.execute "$script" "$parameters" "$work/${result##*/}" \
  2> >(tee "$work"/log.txt >&2)
mv "$work"/results "$folder"
mv "$work/${result##*/}" "$result"
rm -r "$work"
