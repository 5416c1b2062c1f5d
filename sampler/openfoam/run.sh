#!/usr/bin/env bash
# Installs OpenFOAM, builds the plugin and runs both cases; ends with 1 if the first is not as it
# should be.
#
#     run.sh [FOLDER]            FOLDER: working folder, ~/.cache/rebound-tables/openfoam by default
#
# Needs the Python package with matplotlib (pip install '.[plot]'); PYTHON names the interpreter.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"

"$HERE/bend.sh" "$FOLDER"
PYTHONPATH="$HERE/../../tests${PYTHONPATH:+:$PYTHONPATH}" \
    "${PYTHON:-python3}" "$HERE/../../tests/openfoam/foam_wall.py" "$FOLDER"
