#!/usr/bin/env bash
# Usage: build.sh FILE [OPTION ...]                  compiles the library FILE; options go to the compiler
#        build.sh --for CACHE SHOWN COMMAND [...]    runs COMMAND with ROCKSLIP_KERNELS: a library in CACHE/kernels
#        build.sh --headers                          says where the headers of Python are, as options for a compiler
#
# The one command line of a compiler for the kernels; ./in-env, the Dockerfile, CMakeLists.txt (pip, conda), the
# Makefile and tests call it. The compiler is $CXX, or g++.
# --for: ./in-env calls it so, inside the environment. The library's name is a digest of its sources and of its
# compiler's version; it is compiled if it is not there yet. SHOWN is what messages call CACHE.
# What a user's ROCKSLIP_KERNELS names is taken as it is.
set -euo pipefail
here=${0%/*}
compiler=${CXX:-g++}

collect_sources() { # sources=(...), in the order of solver/kernels/library.py wherever we are
    local LC_ALL=C
    sources=("$here"/*.cpp "$here"/*.hpp "$here/build.sh" "$here/symbols.map")
}

digest() { # of what is read, in 16 digits
    local all
    all=$(sha256sum)
    echo "${all:0:16}"
}

# -O3 is a quarter faster than -O2, with the same bits. For any processor of its kind, and without fused
# multiply-adds, which only some of them have: numbers do not depend on the machine.
compile() { # FILE [OPTION ...]
    local file=$1 headers
    shift
    collect_sources
    headers=$(headers)
    # shellcheck disable=SC2086 # $CXX may have options
    $compiler -std=c++17 -O3 -ffp-contract=off -fPIC -shared -fno-semantic-interposition $headers \
        -Wl,--version-script="$here/symbols.map" -DROCKSLIP_SOURCES="\"$(cat "${sources[@]}" | digest)\"" \
        "$@" "$here"/*.cpp -o "$file"
}

headers() { # options for those of $PYTHON, or python3, and of its numpy
    "${PYTHON:-python3}" -c 'import numpy, sysconfig
print("-isystem", sysconfig.get_path("include"), "-isystem", numpy.get_include())'
}

say() { echo "in-env: $*" >&2; }
fail() {
    say "$*"
    exit 4
}

provide() { # CACHE SHOWN: sets ROCKSLIP_KERNELS
    local folder=$1/kernels name new
    collect_sources
    # shellcheck disable=SC2086
    name=$({ LC_ALL=C $compiler --version 2>/dev/null && echo "$MACHTYPE" && cat "${sources[@]}"; } | digest).so ||
        fail "no compiler for the kernels: got $compiler; install g++, or let CXX name another"
    if [[ ${ROCKSLIP_KERNELS:-} = *"/$name" ]]; then return; fi # an ./in-env within another one
    export ROCKSLIP_KERNELS="$folder/$name"
    if [ -e "$ROCKSLIP_KERNELS" ]; then
        touch -c "$ROCKSLIP_KERNELS" 2>/dev/null || true
        return
    fi
    if ! { mkdir -p "$folder" && : >>"$folder/lock"; } 2>/dev/null; then
        fail "$2/kernels cannot be made or written to: set ROCKSLIP_CACHE to a folder of your own"
    fi
    exec 9>>"$folder/lock"
    if command -v flock >/dev/null && ! flock -n 9; then
        say "waiting for another ./in-env that builds the kernels"
        flock 9 || true # where the system has no locks, both build
    fi
    if [ ! -e "$ROCKSLIP_KERNELS" ]; then
        say "building the kernels: some 20 s, once"
        new=$folder/new.$HOSTNAME.$$
        trap 'rm -f "$new"' EXIT
        trap 'exit 130' HUP INT TERM
        compile "$new" || fail "the kernels could not be compiled: the reason stands above"
        mv -f "$new" "$ROCKSLIP_KERNELS"
        trap - EXIT HUP INT TERM
        # Those of sources and compilers that were not used for a month, and what a killed compiler left.
        find "$folder" -type f ! -name lock -mtime +30 -exec rm -f {} +
    fi
    exec 9>&-
}

case ${1:-} in
'' | -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p;}' "$0" ;;
--for)
    cache=$2 shown=$3
    shift 3
    case ${ROCKSLIP_KERNELS:-} in '' | */kernels/????????????????.so) provide "$cache" "$shown" ;; esac
    exec "$@"
    ;;
--headers) headers ;;
*) compile "$@" ;;
esac
