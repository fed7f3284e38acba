"""The only file that draws with VTK: surfaces and tubes in a window off screen, its colours and its depth as arrays.

VTK is used directly: pyvista would do as well, but importing it takes longer than drawing all maps of a run.
"""

from __future__ import annotations

import atexit
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Look:
    """How a surface takes light: colour (None takes those of its cells), shares of light, opacity of cell edges."""

    colour: str | None = None
    ambient: float = 0.0
    diffuse: float = 1.0
    specular: float = 0.0
    specular_power: float = 1.0
    edges: float = 0.0
    smooth: bool = False


@dataclass(frozen=True)
class Canvas:
    """A window off screen with what is drawn in it."""

    window: Any
    renderer: Any

    def light(self, towards: Array, strength: float) -> None:
        """Let light fall from the direction `towards` (3,)."""
        from vtkmodules.vtkRenderingCore import vtkLight

        light = vtkLight()
        light.SetLightTypeToSceneLight()
        light.PositionalOff()
        light.SetPosition(*towards)
        light.SetFocalPoint(0.0, 0.0, 0.0)
        light.SetIntensity(strength)
        self.renderer.AddLight(light)

    def add(self, shape: Any, look: Look) -> Any:
        """Draw a vtkPolyData and return its actor."""
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputData(_smooth(shape) if look.smooth else shape)
        mapper.SetScalarVisibility(look.colour is None)
        mapper.SetScalarModeToUseCellData()
        mapper.SetColorModeToDirectScalars()
        actor.SetMapper(mapper)
        face = actor.GetProperty()
        face.SetAmbient(look.ambient)
        face.SetDiffuse(look.diffuse)
        face.SetSpecular(look.specular)
        face.SetSpecularPower(look.specular_power)
        face.SetLineWidth(1.0)
        if look.smooth:
            face.SetInterpolationToPhong()
        else:
            face.SetInterpolationToFlat()
        if look.colour is not None:
            face.SetColor(*(int(look.colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)))
        if look.edges > 0.0:
            face.EdgeVisibilityOn()
            face.SetEdgeColor(0.0, 0.0, 0.0)
            face.SetEdgeOpacity(look.edges)
        self.renderer.AddActor(actor)
        return actor

    def look(self, middle: Array, away: Array, up: Array, *, height: float, clipping: tuple[float, float]) -> None:
        """Look at `middle` (3,) from `away` (3,) mm off it, `height` mm of the scene filling the picture's height."""
        eye = self.renderer.GetActiveCamera()
        eye.ParallelProjectionOn()
        eye.SetFocalPoint(*middle)
        eye.SetPosition(*(middle + away))
        eye.SetViewUp(*up)
        eye.SetParallelScale(0.5 * height)
        eye.SetClippingRange(*clipping)

    def draw(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Return colours (h, w, 3) and depth (h, w), 0 at the near to 1 at the far plane, top rows first."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        depth = self.depth()
        width, height = self.window.GetSize()
        pixels = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        return np.array(vtk_to_numpy(pixels).reshape(height, width, 3)[::-1]), depth

    def depth(self) -> NDArray[np.float32]:
        """Draw what is visible and return its depth (h, w)."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        self.window.Render()
        width, height = self.window.GetSize()
        depth = vtkFloatArray()
        self.window.GetZbufferData(0, 0, width - 1, height - 1, depth)
        return np.array(vtk_to_numpy(depth).reshape(height, width)[::-1])

    def clear(self) -> None:
        """Take everything off the canvas; its window, and what was compiled to draw in it, serve the next picture."""
        self.renderer.RemoveAllViewProps()
        self.renderer.RemoveAllLights()


@lru_cache(maxsize=1)
def canvas_of(size: tuple[int, int]) -> Canvas:
    """Return the white canvas of a size in pixels, empty after `clear`; call `viz.gl.require` before."""
    from vtkmodules import vtkRenderingOpenGL2  # noqa: F401 (what is drawn with)
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

    window, renderer = vtkRenderWindow(), vtkRenderer()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.AutomaticLightCreationOff()
    renderer.RemoveAllLights()
    atexit.register(window.Finalize)
    return Canvas(window, renderer)


def surface_of(points: Array, faces: IntArray, *, colours: NDArray[np.uint8] | None = None) -> Any:
    """Return faces (f, k) between points (n, 3) as vtkPolyData, with colours (f, 3) where given."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    shape = _between(points, faces, lines=False)
    if colours is not None:
        shape.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colours), deep=True))
    return shape


def tubes_of(points: Array, lines: IntArray, *, radius: float, sides: int) -> Any:
    """Return lines (k, 2) between points (n, 3), joined where they meet, as tubes with a radius in mm."""
    from vtkmodules.vtkFiltersCore import vtkStripper, vtkTubeFilter

    strip, tube = vtkStripper(), vtkTubeFilter()
    strip.SetInputData(_between(points, lines, lines=True))
    strip.JoinContiguousSegmentsOn()
    tube.SetInputConnection(strip.GetOutputPort())
    tube.SetRadius(radius)
    tube.SetNumberOfSides(sides)
    tube.CappingOn()
    tube.Update()
    return tube.GetOutput()


def clipped(shape: Any, low: Array, high: Array) -> Any:
    """Return the part of a surface inside the box between two corners."""
    from vtkmodules.vtkCommonDataModel import vtkPlane
    from vtkmodules.vtkFiltersCore import vtkClipPolyData

    for corner, inwards in ((low, 1.0), (high, -1.0)):
        for axis in np.eye(3):
            plane, clip = vtkPlane(), vtkClipPolyData()
            plane.SetOrigin(*corner)
            plane.SetNormal(*(inwards * axis))
            clip.SetInputData(shape)
            clip.SetClipFunction(plane)
            clip.Update()
            shape = clip.GetOutput()
    return shape


def _between(points: Array, cells: IntArray, *, lines: bool) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    corners, place, shape = vtkCellArray(), vtkPoints(), vtkPolyData()
    offsets = np.arange(len(cells) + 1, dtype=np.int64) * cells.shape[1]
    corners.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, dtype=np.int64).ravel(), deep=True),
    )
    place.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    shape.SetPoints(place)
    (shape.SetLines if lines else shape.SetPolys)(corners)
    return shape


def _smooth(shape: Any) -> Any:
    """Return a surface with normals at its points."""
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    normals = vtkPolyDataNormals()
    normals.SetInputData(shape)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    return normals.GetOutput()
