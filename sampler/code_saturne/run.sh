#!/usr/bin/env bash
# Installs code_saturne, builds it with our user sources, runs the box serially, on two processes
# and from a restart, and compares what happened at its walls with Python; ends with 1 if that
# differs.
#
#     run.sh [FOLDER]      FOLDER: working folder, ~/.cache/rebound-tables/code_saturne by default
#
# Needs a checkout and its Python package (pip install '.[generate]'); PYTHON names the interpreter.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$(realpath -m "${1:-${XDG_CACHE_HOME:-$HOME/.cache}/rebound-tables/code_saturne}")"
python="${PYTHON:-python3}"

mkdir -p "$folder"
bash "$here/install.sh"
"$python" -m sampler export corundum-steel --output "$folder/corundum-steel.rbt"
PYTHONPATH="$here/../../tests${PYTHONPATH:+:$PYTHONPATH}" \
    "$python" "$here/../../tests/code_saturne/saturne_wall.py" "$folder"
