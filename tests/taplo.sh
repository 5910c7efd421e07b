#!/usr/bin/env bash
# Puts Taplo, the checker of TOML that editors use, into target/taplo, where tests/schema.rs looks for
# it. Does nothing if this version is there already.
set -euo pipefail
cd "$(dirname "$0")/.."

package=taplo==0.9.3
folder=target/taplo
installed=$folder/installed-version

if [[ -f $installed && $(<"$installed") == "$package" ]]; then
    exit 0
fi
if ! command -v python3 >/dev/null; then
    echo "tests/taplo.sh: python3 is missing; install it, the tests need it for Taplo" >&2
    exit 1
fi
if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    echo "tests/taplo.sh: python3 cannot make virtual environments; install python3-venv" >&2
    exit 1
fi

echo "installing $package into $folder"
rm -rf "$folder"
mkdir -p target
python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --disable-pip-version-check "$package"
"$folder/bin/taplo" --version
echo "$package" >"$installed"
