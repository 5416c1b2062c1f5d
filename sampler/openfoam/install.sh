#!/usr/bin/env bash
# Installs OpenFOAM v1912 from Debian's packages, and wmake and the headers from its source package.
#
#     install.sh [FOLDER]        FOLDER: working folder, ~/.cache/rebound-tables/openfoam by default
#
# It asks nothing, and does only what is missing. It downloads 45 MB beside the packages, and leaves 0.4 GB in
# FOLDER; the cases that run.sh adds take another 0.6 GB.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/folder.sh"
source "$HERE/environment.sh"

version=1912.200626
packages=(openfoam openfoam-examples g++ make openmpi-bin dpkg-dev bzip2 xz-utils)
keyring=/usr/share/keyrings/debian-archive-keyring.gpg

is_installed() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q "ok installed"; }

# Print the names of the packages that are missing.
missing() {
    local package
    for package in "${packages[@]}"; do
        is_installed "$package" || echo "$package"
    done
}

install_packages() {
    local wanted
    mapfile -t wanted < <(missing)
    [ "${#wanted[@]}" -gt 0 ] || return 0
    [ "$(id -u)" -eq 0 ] || fail "only root can install ${wanted[*]}, and you are $(id -un)"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${wanted[@]}" >"$FOLDER/apt.log" 2>&1 ||
        fail "apt-get did not install ${wanted[*]}; see $FOLDER/apt.log"
}

# Fetch the source package, without a change to the system's own list of sources.
fetch_source() {
    [ -f "$FOLDER/.source-complete" ] && return 0
    mkdir -p "$FOLDER/apt/lists/partial"
    echo "deb-src [signed-by=$keyring] http://deb.debian.org/debian bookworm main" \
        >"$FOLDER/apt/sources.list"
    local options=(
        -q -o "Dir::Etc::SourceList=$FOLDER/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
        -o "Dir::State::Lists=$FOLDER/apt/lists" -o APT::Sandbox::User=
        -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
    )
    rm -rf "$WM_PROJECT_DIR"
    (
        cd "$FOLDER"
        apt-get "${options[@]}" update
        apt-get "${options[@]}" source --only-source "openfoam=$version-1"
    ) >"$FOLDER/source.log" 2>&1 ||
        fail "the source package openfoam $version-1 was not fetched; see $FOLDER/source.log"
    touch "$FOLDER/.source-complete"
}

build_wmake() {
    [ -f "$FOLDER/.wmake-complete" ] && return 0
    ("$WM_DIR/src/Allmake" && cd "$WM_PROJECT_DIR" && "$WM_DIR/wmakeLnIncludeAll" src) \
        >"$FOLDER/wmake.log" 2>&1 ||
        fail "wmake was not built; see $FOLDER/wmake.log"
    touch "$FOLDER/.wmake-complete"
}

system="$(. /etc/os-release 2>/dev/null && echo "${ID:-unknown} ${VERSION_ID:-}" || echo unknown)"
[ "$system" = "debian 12" ] || fail "this is $system; the packages are those of debian 12 (bookworm)"

install_packages
fetch_source
build_wmake
echo "OpenFOAM $version and wmake: $FOLDER"
