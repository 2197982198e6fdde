"""All compiled functions of the package, ahead of time: for a wheel, and beside the first answers.

``geometry.compile_all_kernels`` has those of queries; rules and maps of sensors have a few more.
``python -m drake_geom_ros.every_kernel`` compiles them into the cache and prints its folder.
"""

from __future__ import annotations

from drake_geom_ros.geometry import compile_all_kernels, kernel_cache
from drake_geom_ros.geometry.compiling import Tell
from drake_geom_ros.proximity_rules import decisions, nearest_pairs
from drake_geom_ros.sensed_maps.looking_past import compile_looking_past
from drake_geom_ros.sensed_maps.passes import compile_passes
from drake_geom_ros.sensed_maps.tree_walk import compile_tree_walk


def compile_every_kernel(progress: Tell | None = None) -> None:
    """Compile what the cache lacks; call ``progress(name, number, last)`` before each."""
    compile_passes()
    compile_looking_past()
    compile_tree_walk()
    decisions.prepare()
    nearest_pairs.prepare()
    compile_all_kernels(progress)


if __name__ == '__main__':
    compile_every_kernel(
        lambda name, number, last: print(f'compiling {name} ({number} of {last})', flush=True)
    )
    print(kernel_cache())
