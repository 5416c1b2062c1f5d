# Sourced by the scripts beside it: sets FOLDER, the working folder, from their first argument.

HERE="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
FOLDER="${1:-${XDG_CACHE_HOME:-$HOME/.cache}/rebound-tables/openfoam}"
mkdir -p "$FOLDER"
FOLDER="$(cd "$FOLDER" && pwd)"

fail() {
    echo "$(basename "$0"): error: $1" >&2
    exit 2
}

case "$FOLDER/" in
    "$(cd "$HERE/../.." && pwd)"/*)
        fail "FOLDER: got $FOLDER, allowed: a folder outside the repository"
        ;;
esac
