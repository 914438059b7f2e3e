#!/bin/sh
# Make .venv with the first Python of 3.11 or newer that is found; PYTHON=... names another.
# Debian keeps the module that brings pip in a package of its own; root gets it, others are told.
set -eu

is_new_enough() {
    "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2> /dev/null
}

find_python() {
    for candidate in ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11 python}; do
        if is_new_enough "$candidate"; then
            echo "$candidate"
            return
        fi
    done
    echo "fieldrig needs Python 3.11 or newer, and finds none; name it with PYTHON=..." >&2
    exit 1
}

python=$(find_python)
if ! "$python" -c 'import ensurepip, venv' 2> /dev/null; then
    package=$("$python" -c 'import sys; print("python{}.{}-venv".format(*sys.version_info))')
    if [ "$(id -u)" = 0 ] && command -v apt-get > /dev/null; then
        echo "installing $package"
        apt-get -qq update
        DEBIAN_FRONTEND=noninteractive apt-get -qq install --yes --no-install-recommends "$package" > /dev/null
    else
        echo "this Python cannot make a virtual environment; do: apt-get install $package" >&2
        exit 1
    fi
fi
rm -rf .venv
"$python" -m venv .venv
