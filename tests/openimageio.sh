#!/usr/bin/env bash
# Puts OpenImageIO's tools, oiiotool and idiff, into target/openimageio/bin, where the integration
# tests look for them. Does nothing if this version is there already.
set -euo pipefail
cd "$(dirname "$0")/.."

version=3.2.2.0
folder=target/openimageio
installed=$folder/installed-version

if [[ -f $installed && $(<"$installed") == "$version" ]]; then
    exit 0
fi
if ! command -v python3 >/dev/null; then
    echo "tests/openimageio.sh: python3 is missing; install it, the tests need it for OpenImageIO's tools" >&2
    exit 1
fi
if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    echo "tests/openimageio.sh: python3 cannot make virtual environments; install python3-venv" >&2
    exit 1
fi

echo "installing OpenImageIO $version into $folder"
rm -rf "$folder"
mkdir -p target
python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --disable-pip-version-check "openimageio==$version"
"$folder/bin/oiiotool" --version >/dev/null
"$folder/bin/idiff" --version >/dev/null
echo "$version" >"$installed"
