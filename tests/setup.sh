#!/usr/bin/env bash
# Brings what ./check needs beside Rust: a C linker, Python with virtual environments, and in target/ the
# judges of other people: OpenImageIO's oiiotool and idiff, colour-science, and Taplo,
# which checks scenes by the JSON schema as editors do, the evaluator of FLIP, OpenColorIO, the OpenEXR project's Python package, and the
# engine of Open Job Description. What is there already stays;
# what is missing of the system's packages is installed as root or by sudo, or the command for it is said.
set -euo pipefail
cd "$(dirname "$0")/.."

openimageio=(openimageio==3.2.2.0)
# numpy and scipy are pinned too, so that reference/colorimetry.py makes the same bytes.
colour_science=(colour-science==0.4.7 numpy==2.4.6 scipy==1.17.1 "${openimageio[@]}")
taplo=(taplo==0.9.3)
flip_evaluator=(flip-evaluator==1.7 numpy==2.4.6)
opencolorio=(opencolorio==2.6.0 numpy==2.4.6 "${openimageio[@]}")
# The engine of Open Job Description; its model and sessions are pinned too, which do the work.
openjd=(openjd-cli==0.8.0 openjd-model==0.13.0 openjd-sessions==0.13.0)
clients=(openexr==3.5.3 numpy==2.4.6 "${openimageio[@]}")
least_python=3.11

fail() {
    echo "tests/setup.sh: $*" >&2
    exit 1
}

# Pythons under the names that distributions give them, the usual one first.
find_python() {
    local name
    for name in python3 python3.14 python3.13 python3.12 python3.11; do
        if "$name" -c "import ensurepip, sys, venv
sys.exit(sys.version_info < tuple(map(int, '$least_python'.split('.'))))" 2>/dev/null; then
            command -v "$name"
            return
        fi
    done
    return 1
}

has_all() {
    command -v cc >/dev/null && find_python >/dev/null
}

# What installs a linker and Python here, one command a line; nothing where no package manager is known.
commands() {
    if command -v apt-get >/dev/null; then
        echo "apt-get update --quiet"
        echo "env DEBIAN_FRONTEND=noninteractive apt-get install --quiet --yes --no-install-recommends gcc libc6-dev python3 python3-venv"
    elif command -v dnf >/dev/null; then
        # Where python3 itself is older than that, as in RHEL 9, it stands beside it.
        if dnf --quiet list "python$least_python" >/dev/null 2>&1; then
            echo "dnf install --assumeyes gcc python$least_python"
        else
            echo "dnf install --assumeyes gcc python3"
        fi
    elif command -v zypper >/dev/null; then
        echo "zypper --non-interactive install gcc python311"
    elif command -v pacman >/dev/null; then
        echo "pacman --sync --refresh --noconfirm --needed gcc python"
    elif command -v apk >/dev/null; then
        echo "apk add build-base python3"
    elif command -v brew >/dev/null; then
        echo "brew install python@3.13"
    fi
}

install_system_packages() {
    local list as_root=() command
    list=$(commands)
    [[ -n $list ]] || fail "a C compiler (cc) and Python $least_python or newer with venv are needed; install them, and run ./check again"
    if [[ $list != brew* && $(id -u) != 0 ]]; then
        as_root=(sudo)
        # Without a terminal nobody can give a password.
        if ! command -v sudo >/dev/null || { [[ ! -t 0 ]] && ! sudo --non-interactive true 2>/dev/null; }; then
            fail "a C compiler (cc) and Python $least_python or newer with venv are needed; as root, run
$(sed 's/^/    /' <<<"$list")"
        fi
    fi
    while read -r command; do
        echo "tests/setup.sh: $command"
        # The words of a command are its arguments.
        # shellcheck disable=SC2086
        ${as_root[@]+"${as_root[@]}"} $command </dev/null || fail "this failed: $command"
    done <<<"$list"
    has_all || fail "there is still no C compiler, or no Python $least_python or newer with venv; install them, and run ./check again"
}

# A virtual environment in target/NAME that holds just these packages; does nothing if it does.
environment() {
    local folder=target/$1 installed=target/$1/installed-versions
    shift
    if [[ -f $installed && $(<"$installed") == "$*" ]]; then
        return
    fi
    echo "installing $* into $folder"
    rm -rf "$folder"
    mkdir -p target
    "$(find_python)" -m venv "$folder"
    "$folder/bin/pip" install --quiet --disable-pip-version-check "$@" \
        || fail "pip cannot install $*; it needs the Python Package Index"
    echo "$*" >"$installed"
}

has_all || install_system_packages
environment openimageio "${openimageio[@]}"
environment colour-science "${colour_science[@]}"
environment taplo "${taplo[@]}"
environment flip-evaluator "${flip_evaluator[@]}"
environment opencolorio "${opencolorio[@]}"
environment clients "${clients[@]}"
environment openjd "${openjd[@]}"
# All must run here; ignored is colour-science's warning that it cannot draw without matplotlib.
target/openimageio/bin/oiiotool --version >/dev/null
target/openimageio/bin/idiff --version >/dev/null
target/taplo/bin/taplo --version >/dev/null
target/flip-evaluator/bin/python -c "import flip_evaluator"
target/opencolorio/bin/python -c "import OpenImageIO, PyOpenColorIO"
target/openjd/bin/openjd --version >/dev/null
target/clients/bin/python -c "import OpenEXR, OpenImageIO"
target/colour-science/bin/python -W ignore -c "from colour import read_spectral_image_Fichet2021"

# For the kernels of NEON, which ./check compiles; it says that it leaves them out where this fails.
neon=aarch64-unknown-linux-gnu
if command -v rustup >/dev/null && [[ ! -d $(rustc --print target-libdir --target "$neon") ]]; then
    rustup target add "$neon" >/dev/null 2>&1 || echo "tests/setup.sh: rustup cannot add $neon"
fi
