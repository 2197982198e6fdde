# Work that runs beside this shell, and checks of `run_tests` whose output is kept in a log meanwhile.

# beside COMMAND ...: starts it in a process group of its own, which ends with this shell. `groups`
# has the ids of all that this shell started so.
beside() {
  [[ ${owner_of_groups:-} == "$BASHPID" ]] || { owner_of_groups=$BASHPID groups=(); }
  set -m
  "$@" 9<&- </dev/null &
  set +m
  groups+=($!)
  trap end_groups EXIT
}

# What is ended as soon as it is forked, as a heartbeat, runs the trap of the shell it came from.
end_groups() {
  local group
  ((BASHPID == owner_of_groups)) || return 0
  for group in ${groups[@]+"${groups[@]}"}; do kill -- "-$group" 2>/dev/null || true; done
}

# check_beside NAME COMMAND ...: starts checks (`passes`) beside this shell; `join_checks` shows them.
check_beside() {
  local log=$root/log/beside/$1
  mkdir -p "${log%/*}"
  rm -f "$log".*
  say "$1: beside other work, output in ${log#"$root"/}.log"
  names_beside+=("$1")
  beside check_into "$log" "${@:2}"
}

check_into() {
  local log=$1 verdict='' status=0
  "${@:2}" >"$log.log" 2>&1
  printf '%s\n' "$status" "$verdict" >"$log.verdict"
}

# join_checks: waits for all checks beside, prints the output of each in one piece, and adds its
# verdict to `verdict` and `status`. One that ended without a verdict has failed.
join_checks() {
  local k log found words
  for k in ${names_beside[@]+"${!names_beside[@]}"}; do
    log=$root/log/beside/${names_beside[k]}
    wait "${groups[k]}" || true
    cat "$log.log"
    found=1 words="${names_beside[k]} FAILED, "
    [[ ! -s $log.verdict ]] || { read -r found; IFS= read -r words; } <"$log.verdict"
    verdict+=$words
    ((found == 0)) || status=1
  done
  names_beside=() groups=()
}
