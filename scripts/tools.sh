# Virtual environments for tools that are Python packages. Sourced after apt.sh; defines `tools_in`.
# shellcheck shell=sh

# tools_in DIR PACKAGE...: sees that DIR is a virtual environment with these packages, versions included. Fails where it cannot be.
tools_in() {
    tools=$1
    shift
    if [ -f "$tools/ready" ] && [ "$(cat "$tools/ready")" = "$*" ]; then return 0; fi
    python3 -c 'import venv, ensurepip' >/dev/null 2>&1 || apt_install python3 python3-venv >&2 || return 1
    rm -rf "$tools"
    python3 -m venv "$tools" >&2 || return 1
    "$tools/bin/pip" install --quiet --disable-pip-version-check "$@" >&2 || return 1
    echo "$*" >"$tools/ready"
}
