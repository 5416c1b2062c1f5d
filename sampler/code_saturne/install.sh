#!/usr/bin/env bash
# Installs code_saturne 6.0.2 from Debian 12's packages, without its graphical interface.
#
# Asks for nothing, and does only what is missing, which needs root.
set -euo pipefail

packages=(code-saturne-bin code-saturne-data code-saturne-include gcc gfortran openmpi-bin)

fail() {
    echo "install.sh: error: $1" >&2
    exit 2
}

system="$(. /etc/os-release 2>/dev/null && echo "${ID:-unknown} ${VERSION_ID:-}" || echo unknown)"
[ "$system" = "debian 12" ] || fail "this is $system; the packages are those of debian 12 (bookworm)"

wanted=()
for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q "ok installed" ||
        wanted+=("$package")
done
if [ "${#wanted[@]}" -gt 0 ]; then
    [ "$(id -u)" -eq 0 ] || fail "only root can install ${wanted[*]}, and you are $(id -un)"
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends "${wanted[@]}"; } \
        >&2 || fail "apt-get did not install ${wanted[*]}; its messages are above"
fi
USER="${USER:-nobody}" code_saturne info --version
