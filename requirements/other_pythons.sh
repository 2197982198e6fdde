# The core's quick tests as users of pip get it: `./run test --everything` has a small environment
# with the oldest versions that setup.py allows, under the oldest supported Python, and one with
# the newest that there are, under the newest Python. Neither has ROS. They are made once, as the
# steps of set_up.sh, and where there is no such interpreter the closing line says so.

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

# prepare_ends: sets up those that are not missing; sets `ends` and `missing`.
prepare_ends() {
  local version key
  ends=() missing=()
  for version in "${ends_of_range[@]}"; do
    other_python=$(find_version "$version")
    if [[ -z $other_python ]]; then missing+=("$version"); continue; fi
    other_venv=$venv/core-$version
    other_versions=$(versions_under "$version")
    key=$({
      describe_python "$other_python"
      cat "$root/setup.py"
      [[ $other_versions == lowest-direct ]] || date +%G-%V # what is newest changes: looked up weekly
    } | hash)
    (flock 9; step "core-$version" "$other_venv/.stamp" "$key" make_other_venv) 9<"$root/run"
    ends+=("$version")
  done
}

# versions_under VERSION: which of the versions that setup.py allows are tested, in uv's words.
versions_under() {
  if [[ $1 == "${ends_of_range[0]}" ]]; then echo lowest-direct; else echo highest; fi
}

# `pip install -e '.[test]'`, by uv, for pip has no way to ask for the oldest versions.
make_other_venv() {
  local uv=$venv/bin/uv
  [[ -x $uv ]] || "$venv/bin/python" -m pip install -c "$root/requirements/lock.txt" uv
  rm -rf "$other_venv"
  "$other_python" -m venv --without-pip "$other_venv" # uv installs
  "$uv" pip install --python "$other_venv/bin/python" $(index_of_pip) \
    --resolution "$other_versions" -e "$root[test]"
  [[ $other_versions != highest ]] || # whose names are compared with the record
    "$uv" pip install --python "$other_venv/bin/python" $(index_of_pip) --only-binary :all: drake ||
    echo 'no pydrake for this Python'
}

# test_core VERSION [FILES OF THE TREE]: the quick tests, or these, from an empty folder and
# with nothing of the main environment but its settings.
test_core() {
  local files=("${@:2}")
  (($# > 1)) || mapfile -t files < <(grep -v '^#' "$root/test/quick_core.txt")
  test_in "$venv/core-$1" "${files[@]}"
}

# test_in ENVIRONMENT FILES OF THE TREE
test_in() {
  local python=$1/bin/python cache=$1/numba files=("${@:2}") folder status=0
  folder=$(mktemp -d)
  (cd "$folder" && env -u PYTHONPATH -u VIRTUAL_ENV -u AMENT_PREFIX_PATH NUMBA_CACHE_DIR="$cache" \
    "$python" -m pytest -q -p no:cacheprovider "${files[@]/#/$root/}") || status=$?
  rm -rf "$folder"
  return $status
}

# ---------------------------------------------------------------------------- OpenVDB

# Files of OpenVDB are tested in an environment of the system's Python: OpenVDB's Python module is a
# package of Debian's and Ubuntu's, made for that Python and NumPy 1, and PyPI has no wheel of it.

# prepare_openvdb: sets `openvdb` to that environment, or to nothing where it cannot be had.
prepare_openvdb() {
  local key
  openvdb=$venv/openvdb
  key=$({ describe_python /usr/bin/python3; cat "$root/setup.py"; } | hash)
  (flock 9; step openvdb "$venv/.stamp-openvdb" "$key" make_openvdb_venv) 9<"$root/run"
  [[ -x $openvdb/bin/python ]] || openvdb=''
}

make_openvdb_venv() {
  local system=/usr/bin/python3 uv=$venv/bin/uv
  rm -rf "$openvdb"
  supported "$(describe_python $system)" || { echo 'the system has no Python 3.10 to 3.13'; return; }
  $system -c 'import pyopenvdb' || apt_try python3-openvdb
  $system -c 'import pyopenvdb' || return 0
  "$uv" venv --system-site-packages --python "$system" "$openvdb"
  "$uv" pip install --python "$openvdb/bin/python" $(index_of_pip) \
    -e "$root" 'numpy<2' pytest pytest-timeout pytest-xdist hypothesis
  "$openvdb/bin/python" -c 'import numpy, pyopenvdb; assert numpy.__version__ < "2"'
}

test_openvdb() {
  local name=test_vdb_files_are_level_sets_with_the_places_of_their_points
  test_in "$openvdb" "test/batch/test_distance_field.py::$name"
}
