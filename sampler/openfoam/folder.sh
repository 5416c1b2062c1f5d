# Sourced by the scripts beside it: sets FOLDER, the working folder, from their first argument.

HERE="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
FOLDER="$(realpath -m "${1:-${XDG_CACHE_HOME:-$HOME/.cache}/rebound-tables/openfoam}")"

fail() {
    echo "$(basename "$0"): error: $1" >&2
    exit 2
}

mkdir -p "$FOLDER"
