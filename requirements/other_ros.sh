# The node's quick tests under the other ROS 2 that PyPI has: `./run test --everything` sets up an
# environment for it beside the main one.

other_ros=jazzy

# test_other_ros: a check, in a shell of its own (`check_beside`), for one process sees one ROS.
test_other_ros() {
  local name="node on ROS 2 ${other_ros^}" code
  if [[ -n $underlay ]]; then
    verdict+="$name NOT RUN (the ROS in $underlay is used), "
  elif [[ $wheels != */$other_ros ]]; then # which has the whole suite
    set +e # a step that breaks ends the shell that it runs in
    (set -e; run_on_other_ros)
    code=$?
    set -e
    verdict+=$(told_of_other_ros $code)
    [[ $verdict != *FAILED* ]] || status=1
  fi
}

run_on_other_ros() {
  local files
  others_beside() { :; } # these few files compile what they use
  export ROS_DISTRO=$other_ros
  prepare_with test
  ROS_DOMAIN_ID=$(domain_beside_pytest)
  prepare_with_tf free_domain
  say "the node on ROS 2 ${other_ros^}"
  cd "$root"
  mapfile -t files < <(grep -v '^#' test/quick_ros.txt)
  python -m pytest -q -p no:cacheprovider "${files[@]}"
}

# The workers of pytest, which run meanwhile, have domains 0, 37 and 74 from that of this shell, and
# their shared nodes are 18 further on (test/conftest.py, test/ros/shared_node.py).
domain_beside_pytest() {
  if [[ -n ${ROS_DOMAIN_ID:-} ]]; then echo $((1 + (ROS_DOMAIN_ID + 8) % 101)); else free_domain 9; fi
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
