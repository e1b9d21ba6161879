# What ./scripts/run and ./scripts/test share: Debian packages, configuring, building. To be sourced.

say() { printf '\033[1m[binpick]\033[0m %s\n' "$*" >&2; }

fail() {
  say "$*"
  exit 4
}

# Packages named in scripts/packages.txt that dpkg does not list as installed.
missing_packages() {
  local package
  grep -v '^#' "$repository/scripts/packages.txt" | while read -r package; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
      echo "$package"
  done
}

install_packages() {
  local missing as_root=()
  missing=$(missing_packages)
  [ -n "$missing" ] || return 0
  say "installing Debian packages:" $missing
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "these packages need root: run as root, or install sudo"
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq || fail "apt-get update failed: check the network"
  # shellcheck disable=SC2086  # a list of words
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends $missing >&2 ||
    fail "apt-get install failed: see above"
}

# build PRESET TARGET...
build() {
  local preset=$1
  shift
  if [ ! -f "$repository/build/$preset/build.ninja" ]; then
    say "configuring build/$preset"
    (cd "$repository" && cmake --preset "$preset" >"/tmp/binpick-configure.$$" 2>&1) || {
      cat "/tmp/binpick-configure.$$" >&2
      rm -f "/tmp/binpick-configure.$$"
      fail "configuring failed"
    }
    rm -f "/tmp/binpick-configure.$$"
  fi
  say "building build/$preset"
  cmake --build "$repository/build/$preset" --target "$@" -- --quiet >&2 || fail "the build failed"
}
