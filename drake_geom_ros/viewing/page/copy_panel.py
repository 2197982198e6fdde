"""Panel that exports the current poses as text, and the picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from drake_geom_ros.common.frame_names import AmbiguousNameError, Frame
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.texts import as_csv, as_yaml

_WIDTH, _HEIGHT = 1600, 1000  # [pixels]


class CopyPanel:
    """Exports poses as text, to a field and as a file, and the picture as a file."""

    def __init__(self, gui: Any, scene: LocalScene | None) -> None:
        """Export the poses of ``scene``; None: only the picture can be exported."""
        with gui.add_folder('Copy', expand_by_default=False):
            if scene is not None:
                for name, write in (('yaml', as_yaml), ('csv', as_csv)):
                    button = gui.add_button(f'poses of now as {name.upper()}')
                    button.on_click(partial(self._write, scene, write, f'poses.{name}'))
                self.text = gui.add_text('poses', '', multiline=True)
            gui.add_button('save the picture').on_click(_save_picture)

    def _write(
        self,
        scene: LocalScene,
        write: Callable[[Mapping[Frame, RigidTransform]], str],
        name: str,
        event: Any,
    ) -> None:
        try:
            self.text.value = write(scene.poses())
        except AmbiguousNameError as error:
            self.text.value = f'cannot be written in this form: {error}'
            return
        if event.client is not None:
            event.client.send_file_download(name, self.text.value.encode())


def _save_picture(event: Any) -> None:
    """Let the browser that sent the event render its view, and download that as a file."""
    if event.client is None:
        return
    import imageio.v3  # comes with viser, and takes long to import

    image = event.client.get_render(height=_HEIGHT, width=_WIDTH)
    picture = imageio.v3.imwrite('<bytes>', image, extension='.png')
    event.client.send_file_download('scene.png', picture)
