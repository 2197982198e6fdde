# Sets up what the commands of `run` need, which sources this file: a virtual environment (.venv),
# pinned packages in it, the messages (install/), and the compiled kernels (in .venv). A step is
# done again when the hash over its inputs differs from the stamp it left when it last succeeded,
# and only then.

# ---------------------------------------------------------------------------- what is there

# The prefix of a sourced ROS distribution, empty where none is. This folder's own prefixes do
# not count: somebody may have sourced install/setup.bash.
find_underlay() {
  local entry
  local -a entries
  IFS=: read -ra entries <<<"${AMENT_PREFIX_PATH:-}"
  for entry in ${entries[@]+"${entries[@]}"}; do
    [[ $entry == "$root"/* || ! -f $entry/share/rclpy/package.xml ]] || { echo "$entry"; return; }
  done
}

# Which ROS is used, and where what is made for it is kept: a distribution that is sourced, or what
# PyPI has, Kilted or what ROS_DISTRO names, each in an environment of its own.
choose_ros() {
  local name=kilted folder=$root
  underlay=$(find_underlay)
  [[ -n $underlay ]] || name=${ROS_DISTRO:-kilted}
  wheels=$root/requirements/$name # the pins of its packages
  venv=$root/.venv
  logs=$root/log/setup
  if [[ $name != kilted ]]; then venv+=-$name; logs+=-$name; folder=$venv; fi
  builds=$folder/build
  prefix=$folder/install/drake_geom_msgs
  tf2_msgs=$folder/install/for_tests/tf2_msgs # where install/setup.bash does not look
}

# "3.11.2 /usr/bin/python3" of an interpreter; -S leaves out site hooks (faster).
describe_python() {
  "$1" -S -c 'import sys; print("%d.%d.%d" % sys.version_info[:3], sys.base_prefix)' 2>/dev/null
}

supported() { [[ $1 =~ ^3\.1[0-3]\. ]]; }

# The interpreter to set up with: PYTHON, the one .venv was made with, or what PATH offers.
# With a ROS distribution only python3 will do, for its rclpy is built for that one.
find_python() {
  local candidate version candidates=(python3 python3.13 python3.12 python3.11 python3.10)
  if [[ -n $underlay ]]; then candidates=(python3); fi
  if [[ -n ${PYTHON:-} ]]; then
    candidates=("$PYTHON")
  elif [[ -z $underlay && -x $venv/bin/python ]]; then
    candidates=("$venv/bin/python" "${candidates[@]}")
  fi
  for candidate in "${candidates[@]}"; do
    version=$(describe_python "$candidate") || continue
    supported "$version" && { command -v "$candidate"; return; }
  done
  fail "no Python 3.10 to 3.13 among: ${candidates[*]}.
     Install one (sudo apt-get install -y python3 python3-venv python3-dev) or name one
     (PYTHON=/path/to/python ./run ...)."
}

# The keys of the steps: each is a hash over all that the step's result depends on.
compute_keys() {
  choose_ros
  [[ -d $wheels ]] || fail "ROS_DISTRO=${ROS_DISTRO:-} is none of: $(cd "$root/requirements"; dirname -- */ros.txt | xargs).
     These are on PyPI; of another, source its setup.bash first, or unset ROS_DISTRO."
  python=$(find_python)
  venv_key=$(printf '%s\n' "$venv" "$(describe_python "$python")" "$underlay" | hash)
  packages_key=$(cd "$root/requirements"; 
    GLOBIGNORE=test.txt:lint.txt:peers.txt:mutants.txt:cluster.txt:view.txt:vtk.txt:examples.txt:recordings.txt:wheels.txt:docs.txt
    { echo "$venv_key"; cat -- *.txt "$wheels"/*.txt; } | hash)
  messages_key=$({
    echo "$venv_key" "${cmake_args[@]}"
    cd "$root"
    cat "$wheels"/*.txt requirements/build.txt
    contents msg_defs
  } | hash)
  tf2_msgs_key=$({ echo "$messages_key"; cd "$root"; contents test/msg_defs; } | hash)
}

contents() { find "$1" -type f | LC_ALL=C sort | xargs sha256sum; }
stamped() { [[ -f $1 && $(<"$1") == "$2" ]]; }

up_to_date() {
  stamped "$venv/.stamp" "$venv_key" && stamped "$venv/.stamp-packages" "$packages_key" &&
    stamped "$prefix/.stamp" "$messages_key" && stamped "$venv/.stamp-kernels" "$packages_key"
}

# ---------------------------------------------------------------------------- the steps

set_up() {
  compute_keys
  up_to_date && return
  trap 'say "interrupted; the next ./run goes on from here"; exit 130' INT
  ( # One set-up at a time in this folder: the lock is this script itself.
    flock -n 9 || { say 'another ./run is setting up this folder; waiting for it'; flock 9; }
    compute_keys # it may have been done meanwhile
    up_to_date && exit
    say "setting up in $root (once; ./run clean undoes it)"
    [[ -z $underlay ]] || say "on top of ROS in $underlay"
    stamped "$prefix/.stamp" "$messages_key" || check_system
    step venv "$venv/.stamp" "$venv_key" make_venv
    step tools "$venv/.stamp-tools" "$packages_key" install_tools
    beside packages_and_kernels
    step messages "$prefix/.stamp" "$messages_key" build_messages
    wait "${groups[0]}"
  ) 9<"$root/run"
  trap - INT
}

packages_and_kernels() {
  step packages "$venv/.stamp-packages" "$packages_key" install_packages
  step kernels "$venv/.stamp-kernels" "$packages_key" compile_kernels
}

# step NAME STAMP KEY FUNCTION: runs FUNCTION unless STAMP says that it was done for KEY.
step() {
  stamped "$2" "$3" && return
  rm -f "$2"
  logged "$1" "$4"
  mkdir -p "${2%/*}"
  printf '%s\n' "$3" >"$2"
}

# logged NAME FUNCTION: runs FUNCTION into a log of that name, shows that it lives, and ends
# everything with a reason where it fails.
logged() {
  local name=$1 log=$logs/$1.log start=$SECONDS status=0 self=$BASHPID beat
  mkdir -p "$logs"
  : >"$log"
  heartbeat "$name" "$log" "$self" 9<&- &
  beat=$!
  set +e
  (
    set -eE
    trap 'echo "run: this failed: $BASH_COMMAND"' ERR
    "$2"
  ) >"$log" 2>&1 </dev/null
  status=$?
  set -e
  kill "$beat" 2>/dev/null || true
  wait "$beat" 2>/dev/null || true
  [[ ! -t 2 ]] || printf '\r\033[K' >&2
  if ((status)); then
    say "step '$name' failed (exit code $status) after $((SECONDS - start)) s:"
    { grep -iE '^(error|E:|fatal|CMake Error|run: this failed)|: error:' "$log" ||
        tail -n 8 "$log"; } | tail -n 12 | cut -c 1-200 | sed 's/^/     /' >&2
    fail "whole log: $log. The next ./run goes on from here."
  fi
  say "$name: done in $((SECONDS - start)) s"
}

# Shows that a step lives: on a terminal every second, otherwise every 15 s; ends with its parent.
heartbeat() {
  local name=$1 log=$2 parent=$3 start=$SECONDS next=15 seconds last
  say "$name: started, log in ${log#"$root"/}"
  while sleep 1 && kill -0 "$parent" 2>/dev/null; do
    seconds=$((SECONDS - start))
    last=$(tail -c 2000 "$log" | grep -vE '^ *$|WARNING' | tail -n 1 | cut -c 1-60) || true
    if [[ -t 2 ]]; then
      printf '\r\033[Krun: %s: %d s  %s' "$name" "$seconds" "$last" >&2
    elif ((seconds >= next)); then
      say "$name: $seconds s  $last"
      next=$((next + 15))
    fi
  done
}

# What no wheel brings: a C++ compiler, Python's headers, and ensurepip.
check_system() {
  local short missing=()
  short=$("$python" -S -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
  command -v c++ >/dev/null || missing+=(g++)
  "$python" -c 'import os, sysconfig
raise SystemExit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' ||
    missing+=("$short-dev")
  "$python" -c 'import ensurepip' 2>/dev/null || missing+=("$short-venv")
  ((${#missing[@]})) || return 0
  if [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; then
    apt_packages=("${missing[@]}")
    logged system install_system
  else
    fail "missing on this machine: ${missing[*]}. Install with
     sudo apt-get update && sudo apt-get install -y ${missing[*]}
     (or what your system calls them), then start ./run again."
  fi
}

install_system() {
  export DEBIAN_FRONTEND=noninteractive
  local wait=(-o DPkg::Lock::Timeout=300) # for another apt, on a machine that has just started
  apt-get "${wait[@]}" update
  apt-get "${wait[@]}" install -y --no-install-recommends "${apt_packages[@]}"
}

# apt_try PACKAGE ...: packages for tests, once tried: where they cannot be had the run says what is
# skipped. Only fetching may hang; it is ended, and never the installation, which would leave the
# system's packages broken.
apt_try() {
  [[ $(id -u) == 0 ]] && command -v apt-get || { echo "only root can install $*"; return 0; }
  export DEBIAN_FRONTEND=noninteractive
  local install=(apt-get install -y --no-install-recommends)
  if timeout -k 5 90 apt-get update && timeout -k 5 90 "${install[@]}" --download-only "$@"; then
    timeout -k 5 300 "${install[@]}" --no-download "$@" || echo "cannot be installed: $*"
  else
    echo "cannot be fetched: $*"
  fi
}

# A browser for the tests of the page.
install_browser() { command -v chromium || command -v chromium-browser || apt_try chromium; }

make_venv() {
  # Everything below was made by or for the environment that is replaced.
  local base
  base=$("$python" -S -c 'import sys; print("%s/bin/python%d.%d" % (
    sys.base_prefix, *sys.version_info[:2]))')
  rm -rf "$venv" "$builds"/{drake_geom,tf2,nav,octomap,shape,object_recognition,moveit}_msgs "$prefix" "${tf2_msgs%/*}"
  # A ROS distribution's Python modules are the system's; they must stay visible.
  "$base" -m venv ${underlay:+--system-site-packages} "$venv"
  if [[ -n $underlay ]]; then "$venv/bin/python" -c 'import rclpy'; fi
}

# What messages are built with, and ROS: a small part of all that is downloaded, so building begins
# while the rest is on its way.
install_tools() {
  if [[ -n $underlay ]]; then
    add_sets build
  else
    add_sets build -r "$wheels/ros.txt" -r "$wheels/ros_build.txt" -c "$wheels/lock.txt" \
      -c "$root/requirements/core.txt" numpy
    relocate_exports
  fi
}

install_packages() {
  if [[ -n $underlay ]]; then
    add_sets core demo
  else
    add_sets core demo -c "$wheels/lock.txt"
    "$venv/bin/python" -m pip check
  fi
  # Makes package://drake_geom_ros and share look-ups find this source tree.
  mkdir -p "$venv"/share/{drake_geom_ros,ament_index/resource_index/packages}
  touch "$venv/share/ament_index/resource_index/packages/drake_geom_ros"
  for name in package.xml scenes launch config; do
    ln -sfn "$root/$name" "$venv/share/drake_geom_ros/$name"
  done
}

# add_sets SET ... [PIP ARGUMENTS]: all packages of these sets.
add_sets() {
  local files=() arguments=()
  while (($#)) && [[ $1 != -* ]]; do files+=("$1.txt"); shift; done
  if [[ -n $underlay ]]; then
    # What the distribution has stays as it is, in any version; only the rest is installed.
    # Its messages are compiled against its NumPy, so a newer one beside it would break them.
    (cd "$root/requirements"; "$venv/bin/python" keep_present.py "$venv" "${files[@]}" lock.txt)
    arguments=(-r "$venv/missing.txt")
  else
    arguments=("${files[@]/#/-r$root/requirements/}")
  fi
  pip_add "${arguments[@]}" "$@"
}

# pip_add ARGUMENTS: what is there keeps its version.
pip_add() {
  local kept=${underlay:+$venv/present.txt}
  add_to "$venv/bin/python" -c "${kept:-$root/requirements/lock.txt}" "$@"
}

# add_to PYTHON ARGUMENTS: what pip installs, by uv, which takes a fifth of the time. Of pip's
# settings uv hears only where the index is, and it does not see a distribution's packages: with
# one, and where uv cannot, pip does it.
add_to() {
  local python=$1 quiet=(--disable-pip-version-check --no-input --progress-bar off)
  shift
  if [[ -z $underlay ]]; then
    [[ -x $venv/bin/uv ]] ||
      "$venv/bin/python" -m pip install "${quiet[@]}" -c "$root/requirements/lock.txt" uv || true
    "$venv/bin/uv" pip install --python "$python" $(index_of_pip) "$@" && return
    echo 'uv cannot: pip is asked'
  fi
  "$python" -m pip install "${quiet[@]}" "$@"
}

index_of_pip() {
  local index
  index=${PIP_INDEX_URL:-$("$venv/bin/python" -m pip config get global.index-url 2>/dev/null || true)}
  [[ -z $index ]] || echo "--default-index $index"
}

# pip_add_wheels SET PACKAGE...: each of its packages that has a wheel for this Python and machine.
pip_add_wheels() {
  local set=$1 name missing=()
  shift
  for name; do
    pip_add --only-binary :all: -c "$root/requirements/$set.txt" "$name" || missing+=("$name")
  done
  ((${#missing[@]} < $#)) # all of them: not a matter of wheels
}

install_test() { add_sets test; }
install_docs() { add_sets docs; }
install_lint() { add_sets lint; }
install_peers() { pip_add_wheels peers drake coal mujoco pin libigl pyoctomap pynrrd casadi pandas cyipopt-wheels; }
install_cluster() { pip_add_wheels cluster distributed pyarrow; }
install_view() { pip_add_wheels view viser lcm; }
install_recordings() { pip_add_wheels recordings rosbags mcap; }
install_vtk() { pip_add_wheels vtk vtk; }
install_examples() { pip_add_wheels examples ompl ruckig; }
install_wheels() { pip_add -r "$root/requirements/wheels.txt" -c"$root"/requirements/{view,test,peers,cluster}.txt; }
install_mutants() { pip_add -r "$root/requirements/mutants.txt" pytest-cov; } # lock.txt pins it

# The wheels' CMake exports name folders of the machine that built them.
relocate_exports() {
  local include numpy
  include=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
  numpy=$("$venv/bin/python" -c 'import numpy; print(numpy.get_include())')
  find "$venv/share" -name '*Export.cmake' -print0 | xargs -0 sed -i -E \
    -e "s#/opt/python/[^;\"]*/site-packages/numpy/(_core|core)/include#$numpy#g" \
    -e "s#/opt/python/[^;\"]*/include/python3\.[0-9]+#$include#g"
}

# What the demo needs, in two processes. Once, and not again with each change of a kernel: whoever
# edits them compiles what is used.
compile_kernels() {
  prepare_environment
  unpack_kernels
  local compile=(python -m drake_geom_ros compile "$root/scenes/two_pandas.yaml") cycle
  "${compile[@]}" --part cycle &
  cycle=$!
  "${compile[@]}" --part kernels || { kill "$cycle"; false; }
  wait "$cycle"
}

compile_all() {
  prepare_environment
  DRAKE_GEOM_ROS_COMPILE=first nice python -m drake_geom_ros.every_kernel
}

# others [-n]: the kernels of all other shapes; with -n none, where another ./run compiles them.
others() {
  stamped "$venv/.stamp-others" "$packages_key" && return
  (flock "$@" 9 && step others "$venv/.stamp-others" "$packages_key" compile_all) 9>"$venv/.others"
}

# While what was asked for runs already: who needs one that is not there yet compiles it.
others_beside() {
  stamped "$venv/.stamp-others" "$packages_key" && return
  say "others: the kernels of other shapes are compiled beside this, log in log/setup/others.log"
  others -n </dev/null >/dev/null 2>&1 &
}

build_messages() {
  local python_only=ON
  # A distribution has C++ nodes and recorders, and other versions of the generators.
  [[ -z $underlay ]] || python_only=OFF
  build_interfaces msg_defs "$prefix" -DPYTHON_ONLY=$python_only
}

# The messages of TF, of occupancy grids, of OctoMap and of MoveIt, which distributions bring and no wheel; those that
# others are made of come first.
test_messages=({tf2,nav,octomap,shape,object_recognition,moveit}_msgs)

build_tf2_msgs() {
  prepare_environment
  local name python_only=ON
  [[ -z $underlay ]] || python_only=OFF
  rm -rf "${tf2_msgs%/*}" # those of before would count as a distribution's
  for name in "${test_messages[@]}"; do
    if ! python -c "import $name.msg"; then
      build_interfaces "test/msg_defs/$name" "${tf2_msgs%/*}/$name" -DPYTHON_ONLY=$python_only
    fi
  done
}

enter_test_messages() {
  local name
  for name in "${test_messages[@]}"; do enter "${tf2_msgs%/*}/$name"; done
}

# build_interfaces FOLDER PREFIX [CMAKE ARGUMENTS]: builds the package in FOLDER into PREFIX.
build_interfaces() {
  prepare_environment
  enter_test_messages
  cd "$root"
  # colcon would hold jobs back by the load of the whole machine.
  MAKEFLAGS=-j$(nproc) colcon build --base-paths "$1" --build-base "$builds" \
    --install-base "${2%/*}" --event-handlers console_direct+ --cmake-args "${cmake_args[@]}" \
    -DPython3_EXECUTABLE="$venv/bin/python" "${@:3}"
  enter "$2"
  python -c "import ${2##*/}.msg"
}
