# The node's quick tests under the other ROS 2 that PyPI has: `./run test` without arguments sets up
# an environment for it beside the main one and keeps the verdict for its closing line.

other_ros=jazzy

# test_other_ros: sets `on_other_ros`. In a shell of its own, for one process sees one ROS.
test_other_ros() {
  local name="node on ROS 2 ${other_ros^}" status=0
  if [[ -n $underlay ]]; then
    on_other_ros="$name NOT RUN (the ROS in $underlay is used), "
  elif [[ $wheels != */$other_ros ]]; then # which has the whole suite
    set +e # a step that breaks ends the shell that it runs in
    (set -e; run_on_other_ros)
    status=$?
    set -e
    on_other_ros=$(told_of_other_ros $status)
  fi
}

run_on_other_ros() {
  local files
  export ROS_DISTRO=$other_ros
  prepare_with test
  prepare_with_tf free_domain
  say "the node on ROS 2 ${other_ros^}"
  cd "$root"
  mapfile -t files < <(grep -v '^#' test/quick_ros.txt)
  python -m pytest -q -p no:cacheprovider "${files[@]}"
}

# told_of_other_ros STATUS: the part of the closing line; what cannot be installed has not failed.
told_of_other_ros() {
  ROS_DISTRO=$other_ros
  compute_keys
  if (($1 == 0)); then
    echo "$name ok, "
  elif stamped "$venv/.stamp-tools" "$packages_key" && {
    # Where messages fail, packages are ended beside them.
    stamped "$venv/.stamp-packages" "$packages_key" || ! stamped "$prefix/.stamp" "$messages_key"
  }; then
    echo "$name FAILED, "
  else
    echo "$name NOT RUN (its packages cannot be installed: ${logs#"$root"/}), "
  fi
}
