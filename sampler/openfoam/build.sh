#!/usr/bin/env bash
# Builds libtabulatedRebound.so into FOLDER/lib. Run install.sh before.
#
#     build.sh [FOLDER]          FOLDER: working folder, ~/.cache/rebound-tables/openfoam by default
#
# wmake leaves its objects beside the sources, so it works on a copy in FOLDER.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"
source "$HERE/environment.sh"
export REBOUND_SAMPLER_INCLUDE="$HERE/../c"

[ -f "$FOLDER/.wmake-complete" ] || fail "$FOLDER has no wmake; run: $HERE/install.sh $FOLDER"

# dependencies that wmake has noted for another checkout name files there
if [ "$(cat "$FOLDER/plugin/.built-from" 2>/dev/null)" != "$HERE" ]; then
    rm -rf "$FOLDER/plugin"
fi
header="$REBOUND_SAMPLER_INCLUDE/rebound_sampler.h"
[ -f "$header" ] || fail "$header is missing; run: python sampler/c/build.py"
# wmake overlooks a new header if the header was missing when it first looked for dependencies
if [ "$header" -nt "$FOAM_USER_LIBBIN/libtabulatedRebound.so" ]; then
    rm -rf "$FOLDER/plugin/Make/$WM_OPTIONS"
fi
mkdir -p "$FOLDER/plugin"
echo "$HERE" >"$FOLDER/plugin/.built-from"
cp -r --preserve=timestamps "$HERE/plugin/." "$FOLDER/plugin"
(cd "$FOLDER/plugin" && wmake libso) >"$FOLDER/build.log" 2>&1 ||
    fail "plugin: compilation failed; see $FOLDER/build.log"
echo "plugin: $FOAM_USER_LIBBIN/libtabulatedRebound.so"
