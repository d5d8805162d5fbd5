# shellcheck shell=bash
# Finds and installs programs; sourced by tests/run and tests/bench.

# Debian installs some servers outside the search path.
has() { command -v "$1" >/dev/null 2>&1 || compgen -G "/usr/sbin/$1" >/dev/null || compgen -G "/usr/lib/postgresql/*/bin/$1" >/dev/null; }

# Each argument is program:package, or :package, with the name of Debian's package. Missing packages are installed if
# allowed; otherwise they are listed and the script ends.
need() {
    local entry missing=()
    for entry in "$@"; do
        if [ -z "${entry%%:*}" ] || ! has "${entry%%:*}"; then
            missing+=("${entry##*:}")
        fi
    done
    if [ ${#missing[@]} = 0 ]; then
        return
    fi
    if [ "$(id -u)" = 0 ] && has apt-get; then
        echo "== installing ${missing[*]}"
        apt-get update -qq
        # Debian starts the servers of new packages, unless this program, which an administrator may have made, forbids it.
        local policy=/usr/sbin/policy-rc.d
        if [ ! -e "$policy" ]; then
            printf '#!/bin/sh\nexit 101\n' >"$policy"
            chmod +x "$policy"
            trap 'rm -f /usr/sbin/policy-rc.d' RETURN
        fi
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
    else
        echo "$0: missing programs; install the packages: ${missing[*]}" >&2
        exit 1
    fi
}
