# SPDX-License-Identifier: GPL-3.0-or-later
# Which Debian packages scree needs, said once, and how a script gets them.
# Sourced by deploy/quickstart and tests/run; defines names, does nothing.
# shellcheck shell=bash

PACKAGES_BUILD=(gcc libc6-dev cmake ninja-build pkg-config
    libzmq3-dev libsodium-dev libcjson-dev libhdf5-dev libsqlite3-dev libfftw3-dev)
PACKAGES_TEST=(libcmocka-dev python3 python3-zmq python3-numpy python3-h5py clang-format gnuplot-nox)

say() { printf '%s\n' "$*" >&2; }

# Prints those of its arguments that are not installed.
packages_missing() {
    local name
    for name in "$@"; do
        [ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || printf '%s\n' "$name"
    done
}

# Runs a command as root, or fails when that may not be done. sudo may ask for a
# password only where somebody sits at a terminal.
packages_as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif [ -t 0 ]; then
        sudo "$@"
    else
        sudo -n "$@"
    fi
}
packages_may_install() {
    [ "$(id -u)" -eq 0 ] && return 0
    command -v sudo >/dev/null || return 1
    [ -t 0 ] || sudo -n true 2>/dev/null
}

# Installs what is missing of its arguments and touches nothing when all is
# there, so that it works without a network then. The lists of apt are read anew
# only when they do not know a package or offer a version that is gone.
packages_install() {
    local missing install
    if ! command -v dpkg-query >/dev/null; then
        say "scree: this is not a Debian system; what is needed is called there: $*"
        return 0
    fi
    mapfile -t missing < <(packages_missing "$@")
    [ "${#missing[@]}" -eq 0 ] && return 0
    say "scree: missing packages: ${missing[*]}"
    if ! packages_may_install; then
        say "scree: this user may not install them (not root, no sudo). Ask an administrator for"
        say "    apt-get install ${missing[*]}"
        return 1
    fi
    install=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 install -y -q --no-install-recommends "${missing[@]}")
    if ! apt-cache show --no-all-versions "${missing[@]}" >/dev/null 2>&1 || ! packages_as_root "${install[@]}" >&2; then
        say "scree: reading the package lists anew"
        packages_as_root apt-get update -q >&2 && packages_as_root "${install[@]}" >&2
    fi || {
        say "scree: could not install ${missing[*]}: is there a network? By hand:"
        say "    apt-get update && apt-get install ${missing[*]}"
        return 1
    }
}

# build_configure PRESET FOLDER [OPTION...]: configures once, with the generator
# that the folder was made with, and afresh when the checkout has moved.
build_configure() {
    local preset=$1 folder=$2 cache="$2/CMakeCache.txt"
    shift 2
    if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$cache"; then
        cmake --preset "$preset" --fresh "$@"
    elif [ -f "$cache" ]; then
        cmake -S . -B "$folder" "$@"
    else
        cmake --preset "$preset" "$@"
    fi
}
