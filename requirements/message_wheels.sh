# The second half of `./run wheels`: wheels of drake_geom_msgs for ROS 2 from PyPI, so that a node
# needs no clone, no compiler and no CMake. One for each Python and distribution, because compiled
# messages belong to both.

message_distributions=(kilted jazzy)

# make_message_wheels VERSION: for each distribution, or for ROS_DISTRO alone where it is chosen.
make_message_wheels() {
  local distribution
  for distribution in "${message_distributions[@]}"; do
    [[ -z $underlay && ${ROS_DISTRO:-$distribution} != "$distribution" ]] ||
      make_message_wheel "$1" "$distribution"
  done
}

# make_message_wheel VERSION DISTRIBUTION: from the messages of this folder's set-up where it has
# that Python and distribution, otherwise from an environment of its own, which is made once. It
# runs in a subshell without a sourced distribution, because one process sees one ROS.
make_message_wheel() (
  unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH PYTHONPATH LD_LIBRARY_PATH
  ROS_DISTRO=$2
  compute_keys
  if [[ $(describe_python "$venv/bin/python") != "$1".* ]] ||
    ! stamped "$prefix/.stamp" "$messages_key"; then
    venv=$root/.venv/messages-$2-$1
    builds=$venv/build
    prefix=$venv/install/drake_geom_msgs
    local key
    key=$({ describe_python "$other_python"; cat "$root"/requirements/{build,core,lock}.txt "$wheels"/*.txt; } | hash)
    (flock 9; step "messages-$2-$1-packages" "$venv/.stamp" "$key" make_message_venv) 9<"$root/run"
    key=$({ echo "$key"; cd "$root"; contents msg_defs; } | hash)
    (flock 9; step "messages-$2-$1" "$prefix/.stamp" "$key" build_messages) 9<"$root/run"
  fi
  distribution=$2
  logged "wheel-messages-$2-$1" pack_messages
  say "wheel: $(ls -t "$dist"/drake_geom_msgs_*.whl | head -n 1)"
)

make_message_venv() {
  rm -rf "$venv"
  "$other_python" -m venv "$venv"
  local pins=("$root"/requirements/{build,core,lock}.txt "$wheels/lock.txt")
  add_to "$venv/bin/python" "${pins[@]/#/-c}" -r "$root/requirements/build.txt" \
    -r "$wheels/ros.txt" -r "$wheels/ros_build.txt" numpy
  relocate_exports
}

pack_messages() {
  "$venv/bin/python" -B "$root/requirements/pack_messages.py" "$prefix" "$distribution" "$dist"
}
