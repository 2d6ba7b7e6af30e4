#!/bin/sh
# Run the steps of the Containerfile in a bare Debian, then a command (a chapter of the
# quick report): `make test-container`. debootstrap makes the base image in a folder, and
# chroot runs the steps there, so neither Podman nor Apptainer is necessary.
# It needs root and debootstrap; without them the status is 77.
set -eu
image=$PWD/.cache/container
folder=/

# Run a command in the image, with the settings of this machine's network. The mounts end
# with it.
run() {
  echo "$folder: $1"
  for file in /etc/resolv.conf /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
    if [ -e "$file" ]; then
      mkdir -p "$image${file%/*}"
      cp "$file" "$image$file"
    fi
  done
  unshare --mount sh -euc 'mount --bind /dev "$0/dev"; mount -t proc proc "$0/proc"
    exec chroot "$0" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -c "$1"' \
    "$image" "cd $folder && $1"
}

if [ "$(id -u)" != 0 ] || ! command -v debootstrap >/dev/null; then
  echo "make test-container: skipped; run it as root, with debootstrap" >&2
  exit 77
fi
rm -rf "$image"
# Backslashes at the ends join lines.
while read -r line; do
  word=${line%% *} given=${line#* }
  case $word in
  FROM)
    release=${given##*:}
    debootstrap --variant=minbase "${release%-slim}" "$image" >/dev/null
    ;;
  WORKDIR) folder=$given && mkdir -p "$image$folder" ;;
  COPY) tar -cf - --anchored --exclude-from=.containerignore -- * | tar -xf - -C "$image$folder" ;;
  RUN) run "$given" </dev/null ;;
  esac
done <<END
$(sed -e ':a' -e '/\\$/N; s/\\\n//; ta' Containerfile)
END
run "${1:-make ch02 EFFORT=quick}"
