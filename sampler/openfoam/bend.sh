#!/usr/bin/env bash
# Sand in a bend: installs OpenFOAM, builds the plugin, and runs spheres, the table without the spin
# and the table with it. Prints what hits the walls, and leaves report, numbers and picture in
# FOLDER/bend.
#
#     bend.sh [FOLDER [OPTION...]]   FOLDER: working folder, ~/.cache/rebound-tables/openfoam by
#                                    default; options are those of docs/examples/openfoam_bend
#
# Needs the Python package with matplotlib (pip install '.[plot]'); PYTHON names the interpreter.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"
python="${PYTHON:-python3}"

"$HERE/install.sh" "$FOLDER"
"$HERE/build.sh" "$FOLDER"
"$python" -m sampler export corundum-steel --output "$FOLDER/corundum-steel.rbt"
"$python" "$HERE/../../docs/examples/openfoam_bend" "$FOLDER" "${@:2}"
