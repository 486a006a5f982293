#!/bin/sh
# Installs the program canvass for Linux into a folder, after a look at its checksum.
#
#   CANVASS_ADDRESS  where the files of the release are: https://…, or a folder
#   CANVASS_VERSION  the version
#   CANVASS_FOLDER   the folder for the program; ~/.local/bin if it is not set
set -eu

address=${CANVASS_ADDRESS:-@ADDRESS@}
version=${CANVASS_VERSION:-@VERSION@}
folder=${CANVASS_FOLDER:-$HOME/.local/bin}

fail() {
    echo "install.sh: $1" >&2
    exit 2
}

case $address$version in
    *@*) fail "set CANVASS_ADDRESS to where the files of the release are, and CANVASS_VERSION to its version" ;;
esac
[ "$(uname -s)" = Linux ] || fail "expected Linux, found $(uname -s): see README.md for other systems"
case $(uname -m) in
    x86_64 | amd64) target=x86_64-unknown-linux-musl ;;
    aarch64 | arm64) target=aarch64-unknown-linux-musl ;;
    *) fail "expected a processor x86_64 or aarch64, found $(uname -m)" ;;
esac

name=canvass-$version-$target
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fetch() {
    case $address in
        *://*)
            if command -v curl >/dev/null; then
                curl --fail --silent --show-error --location --output "$work/$1" "$address/$1"
            else
                wget --quiet --output-document "$work/$1" "$address/$1"
            fi ;;
        *) cp "$address/$1" "$work/$1" ;;
    esac || fail "$address/$1 can't be fetched"
}

fetch SHA256SUMS
fetch "$name.tar.gz"
grep -F "  $name.tar.gz" "$work/SHA256SUMS" >"$work/sum" || fail "SHA256SUMS at $address does not name $name.tar.gz"
(cd "$work" && sha256sum --status --check sum) || fail "$name.tar.gz is not the file of the release: its checksum is another one"
tar -xzf "$work/$name.tar.gz" -C "$work"
mkdir -p "$folder"
# A program that runs can't be overwritten, but replaced.
cp "$work/$name/canvass" "$folder/canvass.new"
mv "$folder/canvass.new" "$folder/canvass"
"$folder/canvass" --version
echo "installed as $folder/canvass"
