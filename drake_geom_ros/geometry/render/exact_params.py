"""``RenderEngineExactParams``: labels, colours, edges, samples and role of a renderer."""

from __future__ import annotations

from dataclasses import dataclass, field

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.rgba import Rgba
from drake_geom_ros.geometry.render.render_label import RenderLabel

_MOST_SAMPLES = 8  # along each side of a pixel


@dataclass(frozen=True)
class RenderEngineExactParams:
    """Parameters of an exact renderer.

    - ``default_label``: of geometry without ('label', 'id'); kUnspecified refuses such geometry.
    - ``number_geometries``: geometry without a label gets the lowest free one instead, in the
      order of ids; ``QueryObject.render_legend`` returns them.
    - ``default_diffuse``: of geometry without a colour; None selects a colour for each frame.
    - ``default_clear_color``: of the background.
    - ``color_samples``: samples along each side of a pixel of colour images, from 1 to 8; depth
      and label are those of the pixel's centre.
    - ``edges``: draw edges dark.
    - ``role``: of the visible geometry; kProximity shows the geometry of distance queries.
    """

    default_label: RenderLabel = RenderLabel.kDontCare
    number_geometries: bool = False
    default_diffuse: Rgba | None = field(default_factory=lambda: Rgba(0.9, 0.7, 0.2))
    default_clear_color: Rgba = field(default_factory=lambda: Rgba(0.8, 0.9, 1.0))
    color_samples: int = 1
    edges: bool = True
    role: Role = Role.kPerception

    def __post_init__(self) -> None:
        if self.default_label not in (RenderLabel.kDontCare, RenderLabel.kUnspecified):
            raise ArgumentError(
                f'RenderEngineExactParams: default_label = {self.default_label!r} must be '
                'kDontCare or kUnspecified'
            )
        if self.color_samples not in range(1, _MOST_SAMPLES + 1):
            raise ArgumentError(
                f'RenderEngineExactParams: color_samples = {self.color_samples!r} must be from 1 '
                f'to {_MOST_SAMPLES}'
            )
        if self.role not in (Role.kPerception, Role.kIllustration, Role.kProximity):
            raise ArgumentError(f'RenderEngineExactParams: role = {self.role!r} must be a role')
