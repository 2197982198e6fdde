"""Actors of colour images, with the materials, textures and glTF of files."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from vtkmodules.vtkIOGeometry import vtkOBJReader
from vtkmodules.vtkIOImage import vtkImageReader2Factory
from vtkmodules.vtkIOImport import vtkGLTFImporter, vtkOBJImporter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkTexture,
)

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.meshes.in_memory import InMemoryMesh, MeshSource
from drake_geom_ros.geometry.render.vtk.surfaces import painted
from drake_geom_ros.geometry.render.vtk.windows import hidden_window
from drake_geom_ros.geometry.shapes.from_meshes import Mesh
from drake_geom_ros.math.array_types import Floats

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed

_GLTF = ('.gltf', '.glb')
_Y_UP_TO_Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


def actor_of(surface: Any) -> Any:
    """Return an actor of a surface."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(surface)
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor


def looks_of(packed: Packed, row: int, surface: Any) -> list[tuple[Any, Floats]]:
    """Return the actors of a body in colour images, each with its pose (4, 4) in G.

    ``surface`` is that of its depth and label images. Raises GeometryError for a texture that
    cannot be read.
    """
    shape, diffuse_map = packed.shapes[row], packed.diffuse_maps[row]
    if isinstance(shape, Mesh) and (file_actors := _actors_of_file(shape, diffuse_map)):
        T_GF = np.diag([*shape.scale3(), 1.0])
        if shape.extension() in _GLTF:
            T_GF = T_GF @ _Y_UP_TO_Z_UP  # as _gltf_file does; scales are along the axes of G
        return [(actor, T_GF @ _taken_matrix(actor)) for actor in file_actors]
    bodies = packed.bodies
    facets = bodies.facet_colours[slice(*bodies.triangle_starts[row : row + 2].tolist())]
    if len(facets) and facets.min() >= 0.0:
        surface = painted(surface, facets)
    actor = actor_of(surface)
    if diffuse_map and not len(facets):
        _give_texture(actor, diffuse_map)
    else:
        actor.GetProperty().SetColor(*bodies.colours[row].tolist())
    if len(facets):
        actor.GetProperty().SetInterpolationToFlat()
    return [(actor, np.eye(4))]


def _taken_matrix(actor: Any) -> Floats:
    """Return the matrix (4, 4) of an imported actor, and reset the actor's to the identity."""
    elements = actor.GetMatrix()
    matrix = np.array([[elements.GetElement(i, j) for j in range(4)] for i in range(4)])
    actor.SetPosition(0.0, 0.0, 0.0)
    actor.SetOrigin(0.0, 0.0, 0.0)
    actor.SetOrientation(0.0, 0.0, 0.0)
    actor.SetScale(1.0, 1.0, 1.0)
    return matrix


def _give_texture(actor: Any, file: str) -> None:
    """Set the texture of an actor from a file; raises GeometryError if it cannot be read."""
    reader = None
    if Path(file).is_file():
        reader = vtkImageReader2Factory.CreateImageReader2(file)
    if reader is None:
        raise GeometryError(f"('phong', 'diffuse_map') = {file!r} is no image that can be read")
    reader.SetFileName(file)
    texture = vtkTexture()
    texture.SetInputConnection(reader.GetOutputPort())
    texture.InterpolateOn()
    texture.Update()  # now: the file may be gone when it is drawn
    actor.SetTexture(texture)


def _actors_of_file(mesh: Mesh, diffuse_map: str) -> list[Any]:
    """Return the actors of a mesh whose file defines its looks, empty for other meshes.

    Such files are glTF, .obj with materials, and .obj with a texture: ``diffuse_map``, or an image
    with its name beside it. Actors are unscaled, each with its own matrix.
    """
    source = mesh.source()
    if source.extension() not in (*_GLTF, '.obj'):
        return []
    if source.is_path():
        return _read(source.path(), diffuse_map)
    with tempfile.TemporaryDirectory() as folder:
        return _read(_written(source.in_memory(), Path(folder), source), diffuse_map)


def _written(mesh: InMemoryMesh, folder: Path, source: MeshSource) -> Path:
    """Write the files of a mesh in memory into a folder; return the path of the mesh."""
    for name, file in mesh.supporting_files.items():
        path = (folder / name).resolve()
        if not path.is_relative_to(folder.resolve()):
            raise GeometryError(f'{source.description()!r} names a file outside: {name!r}')
        path.parent.mkdir(parents=True, exist_ok=True)
        content = file.contents() if isinstance(file, MemoryFile) else file.read_bytes()
        path.write_bytes(content)
    path = folder / f'mesh{source.extension()}'
    path.write_bytes(mesh.mesh_file.contents())
    return path


def _read(path: Path, diffuse_map: str) -> list[Any]:
    if path.suffix.lower() in _GLTF:
        return _imported(vtkGLTFImporter(), path)
    if materials := _materials(path):
        importer = vtkOBJImporter()
        importer.SetFileNameMTL(str(materials))
        importer.SetTexturePath(str(path.parent))
        return _imported(importer, path)
    beside = path.with_suffix('.png')
    image = diffuse_map or (str(beside) if beside.is_file() else '')
    if not image:
        return []
    reader = vtkOBJReader()
    reader.SetFileName(str(path))
    reader.Update()
    actor = actor_of(reader.GetOutput())
    _give_texture(actor, image)
    return [actor]


def _materials(path: Path) -> Path | None:
    """Return the file of materials that an .obj file refers to, if it exists."""
    with path.open('rb') as lines:
        for line in lines:
            word, _, name = line.strip().partition(b' ')
            if word == b'mtllib':
                file = path.parent / name.strip().decode(errors='replace')
                return file if file.is_file() else None
    return None


def _imported(importer: Any, path: Path) -> list[Any]:
    """Return the actors that an importer makes from a file."""
    # The importer needs a window, which is never drawn.
    window, renderer = hidden_window(), vtkRenderer()
    window.AddRenderer(renderer)
    importer.SetRenderWindow(window)
    importer.SetFileName(str(path))
    importer.Update()
    actors = importer.GetImportedActors()
    imported = [actors.GetItemAsObject(k) for k in range(actors.GetNumberOfItems())]
    for actor in imported:
        renderer.RemoveActor(actor)
        # As in the other images, a surface is seen from both sides.
        actor.GetProperty().BackfaceCullingOff()
        if actor.GetTexture() is not None:
            actor.GetTexture().Update()  # now: the file may be gone when it is drawn
    return imported
