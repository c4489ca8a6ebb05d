#!/usr/bin/env bash
# tests/packaging/bare_machine.sh [--mirror URL] [--keep] [run|test …]
#
# Proves ./run.sh and ./test.sh from a bare Debian 12, each in a fresh root made by debootstrap
# (minbase: no compiler, no Python, no git). Carried in are a clone of this checkout's HEAD and this
# machine's package configuration (apt and pip settings, proxies, certificates), nothing else. Each
# command runs twice: the second call has to install and build nothing.
#
# Needs root (chroot, mount), debootstrap and git; takes some minutes and 2 GB under $TMPDIR. Logs stay
# in build/bare/. --keep leaves the roots for a look inside; --mirror names another Debian mirror.
# shellcheck disable=SC2016  # what stands in single quotes here is expanded elsewhere
set -eu

checkout=$(cd -P -- "$(dirname -- "$0")/../.." && pwd)
logs=$checkout/build/bare
certificates=/etc/bare-certificates.crt
place="/home/someone/beam wave"  # the space has to be survived
mirror=
keep=

say() { printf 'bare: %s\n' "$*" >&2; }

die() {
  say "$@"
  exit 1
}

# --- making a root ---------------------------------------------------------------------------------

# the mirror this machine takes bookworm from, if it does; debootstrap knows one of its own
usual_mirror() {
  apt-get indextargets --format '$(RELEASE) $(REPO_URI)' 'Created-By: Packages' 2> /dev/null |
    sed -n 's/^bookworm //p' | head -n 1
}

make_root() {
  local root=$1
  say "making a bare root in $root"
  debootstrap --variant=minbase bookworm "$root" ${mirror:+"$mirror"} > "$logs/debootstrap.log" 2>&1 ||
    die "debootstrap failed: see $logs/debootstrap.log"
  carry_apt "$root"
  carry_pip "$root"
  carry_network "$root"
}

# copy ROOT PATH …: the same paths inside, where they exist
copy() {
  local root=$1 path
  shift
  for path; do
    [ -e "$path" ] || continue
    mkdir -p "$root$(dirname -- "$path")"
    cp -aL -- "$path" "$root$(dirname -- "$path")/"
  done
}

carry_apt() {
  copy "$1" /etc/apt/auth.conf /etc/apt/auth.conf.d /etc/apt/trusted.gpg /etc/apt/trusted.gpg.d /etc/apt/keyrings
  apt-config dump Acquire > "$1/etc/apt/apt.conf.d/50bare"
}

carry_pip() {
  copy "$1" /etc/pip.conf /etc/xdg/pip "$HOME/.config/pip" "$HOME/.pip" \
    "${PIP_CONFIG_FILE:-}" "${PIP_FIND_LINKS:-}"
}

carry_network() {
  copy "$1" /etc/resolv.conf /etc/hosts /usr/local/share/ca-certificates
  # under a name of its own: ca-certificates, once installed, writes the usual one anew
  ! [ -e /etc/ssl/certs/ca-certificates.crt ] || cp -L /etc/ssl/certs/ca-certificates.crt "$1$certificates"
}

# --- running inside --------------------------------------------------------------------------------

# what of this machine's environment belongs to the package configuration
package_environment() {
  env | grep -Ei '^(PIP_[A-Z_]*|(https?|ftp|all|no)_proxy)=' | grep -v '^PIP_CERT=' || true
  [ -z "${PIP_CERT:-}${SSL_CERT_FILE:-}${REQUESTS_CA_BUNDLE:-}" ] || echo "PIP_CERT=$certificates"
}

# inside ROOT COMMAND …: in the checkout within the root, with a bare environment, as its only user.
# The mounts belong to a namespace of their own and end with the command.
inside() {
  local root=$1 environment
  shift
  mapfile -t environment < <(package_environment)
  unshare --mount --pid --fork --kill-child bash -c '
    mount -t proc proc "$0/proc" && mount -t tmpfs tmpfs "$0/dev/shm" &&
    mkdir -p "$0/dev/pts" && mount -t devpts -o ptmxmode=666 devpts "$0/dev/pts" &&
    exec chroot "$0" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin "$@"' \
    "$root" "${environment[@]}" /bin/sh -c 'cd "$0" && exec "$@"' "$place" "$@" < /dev/null
}

# timed ROOT LOG COMMAND …: its output in a log, its status and time in one line
timed() {
  local root=$1 log=$logs/$2.log start=$SECONDS
  shift 2
  if inside "$root" "$@" > "$log" 2>&1; then
    say "$* passed in $((SECONDS - start)) s: $log"
  else
    tail -n 40 "$log" >&2
    die "$* failed: see $log"
  fi
}

# --- what is proven --------------------------------------------------------------------------------

# prove NAME: ./NAME.sh, twice, in a root of its own
prove() {
  local root=$work/$1
  cp -a --reflink=auto "$work/bare" "$root"
  mkdir -p "$root$(dirname -- "$place")"
  git clone --quiet --no-hardlinks "$checkout" "$root$place"
  timed "$root" "$1" "./$1.sh"
  timed "$root" "$1-again" "./$1.sh"
  ! grep -E 'installing|Building Fortran' "$logs/$1-again.log" || die "the second ./$1.sh installed or built something"
  "proven_by_$1" "$root$place"
  [ "$keep" ] || rm -rf --one-file-system "$root"
}

proven_by_run() {
  local figure
  for figure in 2 3 4 5 6 7; do
    [ -s "$1/output/paper/fig$figure.png" ] || die "no output/paper/fig$figure.png"
  done
  rm -rf "$logs/paper"
  cp -r "$1/output/paper" "$logs/paper"
  say "six figures: $logs/paper"
}

proven_by_test() { grep -hE 'tests passed' "$logs/test.log" >&2; }

# --- the command line ------------------------------------------------------------------------------

commands=()
while [ $# -gt 0 ]; do
  case $1 in
    --mirror) mirror=$2; shift ;;
    --keep) keep=yes ;;
    run | test) commands+=("$1") ;;
    *) die 'usage: bare_machine.sh [--mirror URL] [--keep] [run|test …]' ;;
  esac
  shift
done
[ ${#commands[@]} -gt 0 ] || commands=(run test)

[ "$(id -u)" -eq 0 ] || die 'needs root: a chroot and its mounts'
for tool in debootstrap git unshare; do
  command -v "$tool" > /dev/null || die "needs $tool"
done
[ -z "$(git -C "$checkout" status --porcelain)" ] || say 'uncommitted changes are not part of what is proven'

mirror=${mirror:-$(usual_mirror)}
mkdir -p "$logs"
work=$(mktemp -d "${TMPDIR:-/tmp}/beamwave-bare.XXXXXX")
[ "$keep" ] || trap 'rm -rf --one-file-system "$work"' EXIT
make_root "$work/bare"
for name in "${commands[@]}"; do
  prove "$name"
done
