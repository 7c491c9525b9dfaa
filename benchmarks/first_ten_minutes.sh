#!/usr/bin/env bash
# Usage: benchmarks/first_ten_minutes.sh [FOLDER]
#
# From nothing to a film: clones this repository into an empty folder, runs there what README.md says under
# "A film in ten minutes", line by line, and prints how long each line takes. Nothing made before is used:
# caches are empty, and so is the store of images where buildah builds them (a Docker or Podman engine keeps
# its own). The folder is left behind where it was given; else it is removed.
set -euo pipefail

repository=$(cd "$(dirname "$0")/.." && pwd)
folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
[ -z "$(ls -A "$folder")" ] || { echo "$folder is not empty" >&2 && exit 2; }
folder=$(cd "$folder" && pwd)

discard() { # the store of images is mounted where buildah keeps containers
    if [ -d "$folder/images" ]; then
        local -x CONTAINERS_STORAGE_CONF=$folder/storage.conf
        buildah rm --all >/dev/null 2>&1 || true
        buildah umount --all >/dev/null 2>&1 || true
        umount "$folder/images/overlay" 2>/dev/null || true
    fi
    rm -rf "$folder/images" "$folder/cache"
    if [ -z "${1:-}" ]; then rm -rf "$folder"; fi
}
trap 'discard "${1:-}"' EXIT

unset SUITE ROCKSLIP_CACHE ROCKSLIP_MOUNT
export XDG_CACHE_HOME=$folder/cache
printf '[storage]\ndriver = "overlay"\ngraphroot = "%s"\nrunroot = "%s"\n' \
    "$folder/images" "$folder/images/run" >"$folder/storage.conf"
export CONTAINERS_STORAGE_CONF=$folder/storage.conf

timed() { # COMMAND ...
    local began=$EPOCHREALTIME
    "$@"
    awk -v a="$began" -v b="$EPOCHREALTIME" -v what="$*" 'BEGIN { printf "%8.1f s  %s\n", b - a, what }' \
        >>"$folder/times"
}

began=$SECONDS
timed git clone --quiet "$repository" "$folder/rockslip"
cd "$folder/rockslip"
mapfile -t lines < <(awk '/^## /{inside = /A film in ten minutes/} inside && /^    /' README.md | sed 's/ \+# .*//;s/^ *//')
[ ${#lines[@]} -gt 0 ] || { echo "README.md has no section 'A film in ten minutes'" >&2 && exit 1; }
for line in "${lines[@]}"; do
    timed bash -c "$line"
done

film=$(find out -name 'film.*' -size +10k)
[ -n "$film" ] || { echo "there is no film" >&2 && exit 1; }
cat "$folder/times"
printf '%8d s  in all, to a film of %d kB\n' $((SECONDS - began)) $(($(stat -c %s "$film") / 1000))
uptime
