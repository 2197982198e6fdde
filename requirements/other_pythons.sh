# The core's quick tests under the oldest and the newest supported Python: `./run test` has a small
# environment for each, with what the core imports and no ROS. It is made once, as the steps of
# set_up.sh, and where there is no such interpreter the closing line says so.

ends_of_range=(3.10 3.13)

# The interpreter of a version such as 3.10, fetched where uv is there; nothing where there is none.
find_version() {
  local candidate
  for candidate in "python$1" "${PYENV_ROOT:-${HOME:-}/.pyenv}"/versions/"$1".*/bin/"python$1"; do
    [[ $(describe_python "$candidate") == "$1".* ]] || continue
    command -v "$candidate"
    return
  done
  command -v uv >/dev/null || return 0
  uv python find "$1" 2>/dev/null && return
  timeout 300 uv python install "$1" >&2 && uv python find "$1" || true
}

# prepare_ends: sets up those that are neither missing nor the main one; sets `ends` and `missing`.
prepare_ends() {
  local version key
  ends=() missing=()
  for version in "${ends_of_range[@]}"; do
    [[ $(describe_python "$venv/bin/python") != "$version".* ]] || continue # has the whole suite
    other_python=$(find_version "$version")
    if [[ -z $other_python ]]; then missing+=("$version"); continue; fi
    other_venv=$venv/core-$version
    key=$({
      describe_python "$other_python"
      cat "$root"/requirements/{core,test,lock}.txt
    } | hash)
    (flock 9; step "core-$version" "$other_venv/.stamp" "$key" make_other_venv) 9<"$root/run"
    ends+=("$version")
  done
}

make_other_venv() {
  rm -rf "$other_venv"
  "$other_python" -m venv "$other_venv"
  add_to "$other_venv/bin/python" -c "$root/requirements/lock.txt" -c "$root/requirements/test.txt" \
    -r "$root/requirements/core.txt" pytest pytest-timeout hypothesis mpmath
}

# test_core VERSION: the quick tests, with nothing of the main environment but its settings.
test_core() {
  local files
  mapfile -t files < <(grep -v '^#' "$root/test/quick_core.txt")
  env -u PYTHONPATH -u VIRTUAL_ENV -u AMENT_PREFIX_PATH NUMBA_CACHE_DIR="$venv/core-$1/numba" \
    "$venv/core-$1/bin/python" -m pytest -q -p no:cacheprovider "${files[@]}"
}
