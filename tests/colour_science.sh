#!/usr/bin/env bash
# Puts colour-science, with OpenImageIO for its reader of spectral EXR files, into
# target/colour-science, where the integration tests look for its python. Does nothing if these
# versions are there already.
set -euo pipefail
cd "$(dirname "$0")/.."

# numpy and scipy are pinned too, so that reference/colorimetry.py makes the same bytes.
packages=(colour-science==0.4.7 numpy==2.4.6 scipy==1.17.1 openimageio==3.2.2.0)
folder=target/colour-science
installed=$folder/installed-versions

if [[ -f $installed && $(<"$installed") == "${packages[*]}" ]]; then
    exit 0
fi
if ! command -v python3 >/dev/null; then
    echo "tests/colour_science.sh: python3 is missing; install it, the tests need it for colour-science" >&2
    exit 1
fi
if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    echo "tests/colour_science.sh: python3 cannot make virtual environments; install python3-venv" >&2
    exit 1
fi
if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
    echo "tests/colour_science.sh: $(python3 --version) is too old for colour-science; install 3.11 or newer" >&2
    exit 1
fi

echo "installing ${packages[*]} into $folder"
rm -rf "$folder"
mkdir -p target
python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --disable-pip-version-check "${packages[@]}"
# Ignored is the warning that it cannot draw without matplotlib.
"$folder/bin/python" -W ignore -c "from colour import read_spectral_image_Fichet2021"
echo "${packages[*]}" >"$installed"
