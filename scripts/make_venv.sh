#!/usr/bin/env bash
# Sets up the virtual environment: finds Python 3.12, installs the package with its dependencies, checks headless GL.
# Usage: scripts/make_venv.sh [DIRECTORY]     (default .venv). Every failure is one line and a non-zero exit status.
set -euo pipefail
cd "$(dirname "$0")/.."
venv="${1:-.venv}"

fail() { echo "error: $*" >&2; exit 1; }

is_python_312() { [ "$("$@" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)" = 3.12 ]; }

# The real interpreter behind a launcher (pyenv's shims need an environment variable to work at all).
executable_of() { "$@" -c 'import sys; print(sys.executable)'; }

find_python_312() {
    local candidate
    for candidate in python3.12 python3 python; do
        if command -v "$candidate" >/dev/null && is_python_312 "$candidate"; then executable_of "$candidate"; return; fi
    done
    for candidate in "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.12*/bin/python3.12; do
        if [ -x "$candidate" ] && is_python_312 "$candidate"; then echo "$candidate"; return; fi
    done
    if command -v uv >/dev/null && candidate="$(uv python find 3.12 2>/dev/null)" && is_python_312 "$candidate"; then
        echo "$candidate"; return
    fi
    return 1
}

install_package() {
    local log="$venv/install.log"
    # A remembered download that was cut off is tried again by pip itself; the log is kept for when it fails.
    "$venv/bin/python" -m pip install --disable-pip-version-check --upgrade "pip>=24" "setuptools>=77" wheel >"$log" 2>&1 \
        || { tail -n 5 "$log" >&2; fail "pip could not install its own tools (full log: $log)"; }
    "$venv/bin/python" -m pip install --disable-pip-version-check --progress-bar off -e ".[dev]" >>"$log" 2>&1 &
    local pip=$! started=$SECONDS latest
    while kill -0 "$pip" 2>/dev/null; do
        latest="$(grep -aE '^ *(Collecting|Downloading|Using cached|Installing|Building)' "$log" | tail -n 1 | cut -c1-60 || true)"
        if [ -t 1 ]; then printf '\r\033[K[%4d s] %s' "$((SECONDS - started))" "$latest"
        elif [ $(((SECONDS - started) % 30)) -eq 0 ]; then printf '[%4d s] %s\n' "$((SECONDS - started))" "$latest"; fi
        sleep 1
    done
    if [ -t 1 ]; then printf '\r\033[K'; fi
    wait "$pip" || { tail -n 5 "$log" >&2; fail "pip could not install the package (full log: $log)"; }
}

ensure_headless_gl() {
    "$venv/bin/python" scripts/check_gl.py --quiet && return
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then as_root=(sudo -n); fi
    if command -v apt-get >/dev/null && { [ "$(id -u)" -eq 0 ] || sudo -n true 2>/dev/null; }; then
        echo "Installing the GL library for headless rendering (libosmesa6) ..."
        { "${as_root[@]}" apt-get update && "${as_root[@]}" apt-get install -y --no-install-recommends libosmesa6; } \
            >"$venv/apt.log" 2>&1 || fail "apt-get could not install libosmesa6 (full log: $venv/apt.log)"
    fi
    "$venv/bin/python" scripts/check_gl.py || exit 1
}

if [ ! -x "$venv/bin/python" ] || ! is_python_312 "$venv/bin/python"; then
    python="$(find_python_312)" || fail "Python 3.12 is needed and was found neither on the PATH nor through pyenv or uv"
    echo "Creating $venv with $python ..."
    "$python" -m venv --clear "$venv"
fi
echo "Installing the package and its dependencies into $venv (a few minutes the first time; torch alone is large) ..."
install_package
ensure_headless_gl
echo "$venv is ready."
