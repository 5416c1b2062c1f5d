#!/usr/bin/env bash
# Sand in a bend: installs OpenFOAM, builds the plugin, and runs spheres, the table without the spin
# and the table with it. Prints what hits the walls, and draws it to FOLDER/bend/bend.png.
#
#     bend.sh [FOLDER]           FOLDER: working folder, ~/.cache/rebound-tables/openfoam by default
#
# Needs the Python package with matplotlib (pip install '.[plot]'); PYTHON names the interpreter.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"
source "$HERE/environment.sh"
python="${PYTHON:-python3}"
bend="$FOLDER/bend"

"$HERE/install.sh" "$FOLDER"
"$HERE/build.sh" "$FOLDER"
"$python" -m sampler export corundum-steel --output "$FOLDER/corundum-steel.rbt"

# Runs a program of OpenFOAM in a case.
foam() {
    (cd "$bend/$1" && "$2") >"$bend/$1/log.$2" 2>&1 || fail "$2 failed; see $bend/$1/log.$2"
}

# Makes a fresh copy of the case, with its mesh.
copy_case() {
    rm -rf "${bend:?}/$1"
    mkdir -p "$bend"
    cp -r "$HERE/cases/bend" "$bend/$1"
    cp "$FOLDER/corundum-steel.rbt" "$bend/$1"
    foam "$1" blockMesh
}

# Flies parcels with a wall model, and with or without their spin.
fly() {
    copy_case "$1"
    sed -i "s/default steadyState/default Euler/" "$bend/$1/system/fvSchemes"
    sed -i -e "s/^wallModel .*/wallModel $2;/" -e "s/^keepsSpin .*/keepsSpin $3;/" \
        "$bend/$1/constant/kinematicCloudProperties"
    cp "$gas"/{U,k,epsilon,nut} "$bend/$1/0"
    foam "$1" icoUncoupledKinematicParcelFoam
}

copy_case gas
mv "$bend/gas/system/controlDict.gas" "$bend/gas/system/controlDict"
foam gas simpleFoam
gas="$(printf '%s\n' "$bend"/gas/[1-9]* | sort -V | tail -n 1)"
fly sphere standardWallInteraction no
fly table-without-spin tabulatedRebound no
fly table tabulatedRebound yes
"$python" "$HERE/../../docs/studies/openfoam_bend.py" "$FOLDER" --figure "$bend/bend.png"
