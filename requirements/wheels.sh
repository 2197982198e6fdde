# `./run wheels [VERSION ...]`: dist/ gets the source distribution and, for each Python that is here
# or for those that are named (3.11), a wheel with kernels and wheels of the messages. The kernels
# run on every CPU of this machine's type; they are loaded by the versions of Numba and llvmlite
# that requirements/ pins, others compile their own.

kernel_pythons=(3.10 3.11 3.12 3.13)
dist=${DRAKE_GEOM_ROS_WHEELS:-$root/dist}

wheels_command() {
  local version other_python
  compute_keys
  (flock 9; step venv "$venv/.stamp" "$venv_key" make_venv) 9<"$root/run" # it has uv
  (($#)) || set -- "${kernel_pythons[@]}"
  for version; do
    other_python=$(find_version "$version")
    if [[ -z $other_python ]]; then
      say "wheels for Python $version: NOT BUILT (no such interpreter here)"
      continue
    fi
    make_wheel "$version"
    make_message_wheels "$version"
  done
  (flock 9; step wheels "$venv/.stamp-wheels" "$(hash <"$root/requirements/wheels.txt")" install_wheels) 9<"$root/run"
  "$venv/bin/python" -m twine check --strict "$dist"/*
}

# make_wheel VERSION: in an environment of its own, which is made once, from a copy of the tree. So
# is the source distribution, which is the same whatever Python makes it.
make_wheel() {
  local wheel_venv=$venv/wheel-$1 key tree
  key=$({ describe_python "$other_python"; cd "$root/requirements"; cat core.txt lock.txt; } | hash)
  (flock 9; step "wheel-$1-packages" "$wheel_venv/.stamp" "$key" make_wheel_venv) 9<"$root/run"
  tree=$(mktemp -d)
  copy_tree "$tree"
  logged "wheel-$1" build_wheel
  rm -rf "$tree"
  say "wheel: $(ls -t "$dist"/drake_geom_ros-*.whl | head -n 1)"
}

make_wheel_venv() {
  rm -rf "$wheel_venv"
  "$other_python" -m venv "$wheel_venv"
  add_to "$wheel_venv/bin/python" -c "$root/requirements/lock.txt" -c "$root/requirements/build.txt" \
    -r "$root/requirements/core.txt" setuptools
}

# copy_tree FOLDER: what the package is built from, and nothing that a build or a set-up leaves.
copy_tree() {
  (cd "$root" && tar cf - --exclude=__pycache__ --exclude=_kernels \
    setup.py setup.cfg pyproject.toml package.xml README.md LICENSE resource scripts config launch \
    scenes drake_geom_ros) | tar xf - -C "$1"
}

# Numba's own wheel says which platforms run what it compiles. setuptools is called as pip would: the
# pip that some Pythons bring cannot hand it two options.
build_wheel() {
  local python=$wheel_venv/bin/python built
  built=$(mktemp -d)
  (cd "$tree" && "$python" -c 'import sys, setuptools.build_meta as build
build.build_sdist(sys.argv[1])' "$built") # before there are kernels, which it has none of
  compile_for_any_cpu "$tree" "$python"
  (cd "$tree" && "$python" -c 'import sys, setuptools.build_meta as build
tag = sys.implementation.cache_tag.replace("cpython-", "cp")
options = [f"--plat-name={sys.argv[2]}", f"--python-tag={tag}"]
build.build_wheel(sys.argv[1], {"--build-option": options})' \
    "$built" "$("$python" "$root/requirements/platform_of.py" numba)")
  mkdir -p "$dist"
  mv "$built"/* "$dist/"
  rm -rf "$built"
}

# compile_for_any_cpu TREE PYTHON: fills drake_geom_ros/_kernels of a tree. What was compiled for an
# earlier wheel of the same sources is there already.
compile_for_any_cpu() {
  local folder kernels=$1/drake_geom_ros/_kernels
  (cd "$1" && env -u PYTHONPATH NUMBA_CACHE_DIR="$wheel_venv/numba" NUMBA_CPU_NAME=generic \
    DRAKE_GEOM_ROS_COMPILE=first nice "$2" -m drake_geom_ros.every_kernel) | tee "$1/folder"
  folder=$(tail -n 1 "$1/folder")
  mkdir "$kernels"
  cp -r "$folder" "$kernels/"
  rm -rf "$kernels"/*/locks "$kernels"/*/*/locks
}

# The kernels of wheels for this Python in dist/, of these sources: a set-up compiles none of them.
unpack_kernels() {
  local wheel tag
  tag=$("$venv/bin/python" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
  for wheel in "$dist"/drake_geom_ros-*-"$tag"-none-*"$(uname -m)".whl; do
    [[ ! -f $wheel ]] || "$venv/bin/python" "$root/requirements/unpack_kernels.py" "$wheel" "$NUMBA_CACHE_DIR"
  done
}
