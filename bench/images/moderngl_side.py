"""The same three images by OpenGL alone: what a small renderer on moderngl takes, as a yardstick.

Instanced triangles, one pass into three attachments, read back. Round shapes are tessellated as
the viewer has them. It needs ``pip install moderngl`` and EGL, and runs without a screen.
"""

from __future__ import annotations

import importlib.util
from collections import defaultdict
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.scaled_surfaces import DrawnSurface, parts_of

_VERTEX = """
#version 330
in vec3 position; in mat4 X_CG; in vec3 colour; in int label;
uniform mat4 projection;
out vec3 p_C; flat out vec3 own; flat out int number;
void main() {
    vec4 p = X_CG * vec4(position, 1.0);
    p_C = p.xyz; own = colour; number = label;
    gl_Position = projection * p;
}
"""
_FRAGMENT = """
#version 330
in vec3 p_C; flat in vec3 own; flat in int number;
layout(location = 0) out vec4 colour;
layout(location = 1) out float depth;
layout(location = 2) out int label;
void main() {
    vec3 n = normalize(cross(dFdx(p_C), dFdy(p_C)));
    colour = vec4(own * (0.35 + 0.65 * abs(dot(n, normalize(p_C)))), 1.0);
    depth = p_C.z; label = number;
}
"""
_COLOUR = (0.9, 0.9, 0.9)


class Camera(NamedTuple):
    """Where a camera is, what it sees, and the depths between which it sees it [m]."""

    X_WC: RigidTransform
    intrinsics: CameraInfo
    near: float
    far: float


def why_not() -> str:
    """Return why it cannot draw here; an empty text: it can."""
    if importlib.util.find_spec('moderngl') is None:
        return 'moderngl is not installed: pip install moderngl'
    import moderngl

    try:
        moderngl.create_context(standalone=True, backend='egl').release()
    except Exception as error:  # whatever a driver that is not there raises
        return f'moderngl finds no EGL: {error}'
    return ''


def projection(camera: Camera) -> NDArray[np.float32]:
    """Return the matrix (4, 4) from C to clip space; the image's first row is the lowest there."""
    k, near, far = camera.intrinsics, camera.near, camera.far
    width, height = k.width(), k.height()
    matrix = np.zeros((4, 4), np.float32)
    matrix[0, 0], matrix[0, 2] = 2 * k.focal_x() / width, 2 * k.center_x() / width - 1
    matrix[1, 1], matrix[1, 2] = 2 * k.focal_y() / height, 2 * k.center_y() / height - 1
    matrix[2, 2:] = (far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = 1.0
    return matrix


def drawer(bodies: list[tuple[Shape, RigidTransform]], camera: Camera) -> Callable[[], Any]:
    """Return what draws the bodies and returns colour, depth and label, (height, width) each."""
    import moderngl

    context = moderngl.create_context(standalone=True, backend='egl')
    size = camera.intrinsics.width(), camera.intrinsics.height()
    target = context.framebuffer(
        [
            context.texture(size, 4, dtype='f1'),
            context.texture(size, 1, dtype='f4'),
            context.texture(size, 1, dtype='i4'),
        ],
        context.depth_renderbuffer(size),
    )
    program = context.program(_VERTEX, _FRAGMENT)
    program['projection'].write(projection(camera).T.tobytes())
    arrays = [
        _array(context, program, surface, instances)
        for surface, instances in _instances(bodies, camera.X_WC.inverse())
    ]

    def task() -> Any:
        target.use()
        context.enable_only(moderngl.DEPTH_TEST)
        target.clear()
        for array, count in arrays:
            array.render(moderngl.TRIANGLES, instances=count)
        color = target.read(components=4)
        depth = target.read(attachment=1, components=1, dtype='f4')
        label = target.read(attachment=2, components=1, dtype='i4')
        return (
            np.frombuffer(color, np.uint8).reshape(*size[::-1], 4),
            np.frombuffer(depth, np.float32).reshape(size[::-1]),
            np.frombuffer(label, np.int32).reshape(size[::-1]),
        )

    return task


def _instances(
    bodies: list[tuple[Shape, RigidTransform]], X_CW: RigidTransform
) -> list[tuple[DrawnSurface, bytes]]:
    """Return each surface with its instances: poses and scales in C, colours, and labels."""
    surfaces, rows = {}, defaultdict(list)
    record = np.dtype([('X_CG', 'f4', 16), ('colour', 'f4', 3), ('label', 'i4')])
    for index, (shape, X_WG) in enumerate(bodies):
        for part in parts_of(shape):
            matrix = (X_CW @ X_WG @ part.X_GS).GetAsMatrix4() @ np.diag([*part.scale, 1.0])
            # The labels of bench.images.scenes, and one more: what is cleared has 0.
            rows[part.surface.key].append((matrix.T.ravel(), _COLOUR, index % 30_000 + 1))
            surfaces[part.surface.key] = part.surface
    return [(surfaces[key], np.array(each, record).tobytes()) for key, each in rows.items()]


def _array(context: Any, program: Any, surface: DrawnSurface, instances: bytes) -> tuple[Any, int]:
    """Return the vertex array of a surface, and how many instances it has."""
    vertices = context.buffer(surface.vertices.astype('f4').tobytes())
    indices = context.buffer(surface.triangles.astype('i4').tobytes())
    content = [
        (vertices, '3f', 'position'),
        (context.buffer(instances), '16f 3f 1i/i', 'X_CG', 'colour', 'label'),
    ]
    return context.vertex_array(program, content, indices), len(instances) // 80
