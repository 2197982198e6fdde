"""A mesh file as the scene of ``render`` and ``view``, as its hull and as a solid."""

import argparse

import numpy as np
import pytest
from conventions.source_tree import ROOT
from viewing.page.pages import wait_for

from drake_geom_ros.command_line import view
from drake_geom_ros.command_line.program import main
from drake_geom_ros.viewing.looks import mesh_surface

# The cross-section of an L, from (0, -0.05, 0) to (0.3, 0.05, 0.2) m.
BRACKET = str(ROOT / 'examples/models/bracket.obj')
CORNERS = np.array([[0, -0.05, 0], [0.3, 0.05, 0.2]])


@pytest.mark.parametrize('options', [(), ('--solid',)])
def test_images_show_the_surface_of_the_file(tmp_path, options):
    """From the side: the leg, the notch above it, which a hull would fill, and the arm."""
    images = pytest.importorskip('PIL.Image')
    pytest.importorskip('matplotlib')
    looks = ('--from', '0.15', '-1', '0.1', '--at', '0.15', '0', '0.1', '--size', '120', '120')
    command = ('render', BRACKET, *looks, '--fov-y', '0.4', *options)
    assert main([*command, '--out', str(tmp_path)]) == 0
    depth = np.asarray(images.open(tmp_path / 'camera_depth.png')).astype(int)
    # 120 pixels are 2 * 0.95 * tan(0.2) m wide at the side that faces the camera.
    metre = 60 / (0.95 * np.tan(0.2))
    for x, z, is_body in ((0.025, 0.15, True), (0.2, 0.15, False), (0.2, 0.025, True)):
        row, column = round(60 - (z - 0.1) * metre), round(60 + (x - 0.15) * metre)
        assert depth[row, column] == (950 if is_body else 0), (x, z)


@pytest.mark.parametrize(('options', 'triangles'), [((), 16), (('--solid',), 20)])
def test_a_page_shows_it_as_it_counts_and_from_outside(options, triangles):
    """The hull of an L has 10 corners, so 16 triangles; the L itself has 20."""
    pytest.importorskip('viser', reason='draws the page')
    parser = argparse.ArgumentParser()
    view.add_to(parser.add_subparsers())
    page = view.open_page(parser.parse_args(['view', BRACKET, '--port', '18290', *options]))
    try:
        wait_for(lambda: page.moment is not None, 'the first picture')
        (look,) = page.moment.geometries.looks
        vertices, faces = mesh_surface(look.shape, look.solid)
        assert len(faces) == triangles
        np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], CORNERS)
        camera = page._server.initial_camera
        middle = CORNERS.mean(axis=0)
        np.testing.assert_allclose(camera.look_at, middle, rtol=0, atol=1e-6)
        diagonal = np.linalg.norm(CORNERS[1] - CORNERS[0])
        assert np.linalg.norm(camera.position - middle) > diagonal / 2.0
    finally:
        page.close()
