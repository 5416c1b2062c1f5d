#!/usr/bin/env bash
# Installs OpenFOAM, builds the plugin and runs both cases; ends with 1 if a case is not as it
# should be.
#
#     run.sh [FOLDER]            FOLDER: working folder, ~/.cache/rebound-tables/openfoam by default
#
# Needs the Python package with matplotlib (pip install '.[plot]'); PYTHON names the interpreter.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"
source "$HERE/environment.sh"
python="${PYTHON:-python3}"
cases="$HERE/../../tests/openfoam"

"$HERE/install.sh" "$FOLDER"
"$HERE/build.sh" "$FOLDER"
"$python" -m sampler export corundum-steel --output "$FOLDER/corundum-steel.rbt"
"$python" "$cases/wall.py" "$FOLDER"
"$python" "$cases/bend.py" "$FOLDER"
