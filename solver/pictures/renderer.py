"""Bodies, floor and forces as pyvista draws them off screen, for films and for stills in space."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.errors import EnvironmentTrouble
from solver.pictures.links import LOOKS, LinkFrames
from solver.pictures.meshes import EDGE_NORMALS, EDGES, SHARP
from solver.pictures.style import FLOOR, STRESS
from solver.scene.time import rounded_down
from solver.types import Array

Pixels = NDArray[np.uint8]
"""A picture: rows, columns, red, green and blue."""

#: From where bodies in space are seen: to the right of the front and above the horizontal, rad.
ASIDE, ABOVE = math.radians(25), math.radians(20)

EDGE = "#101010"

#: Edges are drawn nearer to the eye than faces, by this part of its distance.
NEARER = 5e-4

#: Light that comes from everywhere: on sides, and so that stresses have the colours of their bar.
AMBIENT, AMBIENT_STRESS = 0.55, 0.8

#: Samples of a pixel, so that edges are smooth.
SAMPLES = 8

#: Draws a window: the process ends badly where VTK cannot.
PROBE = "import pyvista; p = pyvista.Plotter(off_screen=True); p.show()"


def view_axes(dimension: int) -> Array:
    """Directions in space that are seen to the right, up, and towards the eye, as rows."""
    if dimension == 2:
        return np.eye(3)
    right = np.array([math.cos(ASIDE), math.sin(ASIDE), 0.0])
    level = math.cos(ABOVE) * np.array([math.sin(ASIDE), -math.cos(ASIDE), 0.0])
    eye = level + np.array([0.0, 0.0, math.sin(ABOVE)])
    return np.stack([right, np.cross(eye, right), eye])


def in_view(places: Array) -> Array:
    """Places (n, d) as they are seen: to the right and up, m, (n, 2)."""
    dimension = places.shape[1]
    return np.asarray(places @ view_axes(dimension)[:2, :dimension].T)


@contextmanager
def display() -> Iterator[None]:
    """Have a display to draw on where VTK needs one: an X server of our own, else the user's."""
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (which windows there are)
        from vtkmodules.vtkRenderingCore import vtkRenderWindow
    except ImportError as error:
        raise EnvironmentTrouble(f"VTK cannot draw here: {error}") from error
    if not str(vtkRenderWindow().GetClassName()).startswith("vtkX"):
        yield
        return
    program, before = shutil.which("Xvfb"), os.environ.get("DISPLAY")
    if program is None:
        probe = [sys.executable, "-c", PROBE]
        if not before or subprocess.run(probe, capture_output=True).returncode:
            raise EnvironmentTrouble("VTK draws through an X server here: install xvfb")
        yield
        return
    server, number = _start(program)
    os.environ["DISPLAY"] = f":{number}"
    try:
        yield
    finally:
        if before is None:
            del os.environ["DISPLAY"]
        else:
            os.environ["DISPLAY"] = before
        server.terminate()
        server.wait()


def _start(program: str) -> tuple[subprocess.Popen[bytes], int]:
    """Start a server on a free display, whose number it prints; returns it and the number."""
    answer, told = os.pipe()
    words = [program, "-displayfd", str(told), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"]
    silent = subprocess.DEVNULL
    # A session of its own: Ctrl-C ends the film, and the film ends the server.
    server = subprocess.Popen(
        words, pass_fds=[told], stdout=silent, stderr=silent, start_new_session=True
    )
    os.close(told)
    with os.fdopen(answer) as stream:
        number = stream.readline().strip()
    if not number:
        server.wait()
        raise EnvironmentTrouble("Xvfb did not start")
    return server, int(number)


class Renderer:
    """Draws bodies on their floor, without perspective: the plane, or space from the front."""

    def __init__(
        self,
        size: tuple[int, int],
        low: Array,
        high: Array,
        *,
        window: tuple[Array, Array],
        floor: float,
        limit: float,
        beyond: float,
        line: float = 1.0,
    ):
        """Set up for pictures of a size (width, height), pixels.

        Args:
            size: Of the picture.
            low: Least place of what is drawn, m, (d,).
            high: Greatest place, m, (d,).
            window: Least and greatest place in the picture as they are seen, m, (2,).
            floor: Height of the floor, m.
            limit: Stress of the last colour, Pa.
            beyond: How far the floor reaches beyond low and high, m.
            line: Width of the edges of meshes, pixels; those of rigid bodies are twice as wide.
        """
        import pyvista

        self._limit, self._dimension = limit, len(low)
        self._line = line
        self._plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size))
        self._plotter.enable_anti_aliasing("msaa", multi_samples=SAMPLES)
        self._plotter.set_background("white")
        self._add_floor(low, high, floor, beyond)
        self._drawn: list[Any] = []
        self._axes, middle = view_axes(self._dimension), 0.5 * (low + high)
        depth = middle @ self._axes[2, : self._dimension]
        self._middle = np.array([*(0.5 * (window[0] + window[1])), depth]) @ self._axes
        self._far = 4 * float(np.max(high - low)) + 2 * beyond
        half = 0.5 * (window[1] - window[0])
        self._plotter.camera.SetParallelProjection(True)
        self._plotter.camera.SetViewUp(*self._axes[1])
        self._plotter.camera.SetParallelScale(float(max(half[1], half[0] * size[1] / size[0])))

    def draw(
        self,
        bodies: Sequence[tuple[Any, str]],
        arrows: Sequence[tuple[Any, str]] = (),
        ground: Array | None = None,
    ) -> Pixels:
        """The picture of bodies and arrows, `pyvista.PolyData` with their colours, m.

        A body that has a stress is coloured by it. The ground is displaced, m, (d,).
        """
        for actor in self._drawn:
            self._plotter.remove_actor(actor, render=False)
        self._drawn = [self._body(*body) for body in bodies]
        self._drawn += [
            self._edges(surface) for surface, _ in bodies if EDGES in surface.field_data
        ]
        self._drawn += [self._arrow(*arrow) for arrow in arrows]
        middle = self._middle.copy()
        if ground is not None:  # seen from a place at rest
            middle[: len(ground)] -= ground
        self._plotter.camera.SetFocalPoint(*middle)
        self._plotter.camera.SetPosition(*(middle + self._far * self._axes[2]))
        self._plotter.renderer.ResetCameraClippingRange()
        self._plotter.render()
        return np.asarray(self._plotter.screenshot(return_img=True))[:, :, :3].copy()

    def _body(self, surface: Any, colour: str) -> Any:
        """A body, coloured by its stress where it has one; in space its sides differ in shade."""
        look: dict[str, Any] = {"color": colour, "line_width": 2 * self._line}
        light = AMBIENT
        if "von_mises" in surface.cell_data and self._limit > 0:
            look = {"scalars": "von_mises", "cmap": STRESS, "clim": (0, self._limit)}
            look |= {"show_scalar_bar": False, "edge_opacity": 0.5, "line_width": self._line}
            light = AMBIENT_STRESS
        look |= {"show_edges": EDGES not in surface.field_data, "edge_color": EDGE}
        look |= {"render": False, "reset_camera": False}
        lit = {"lighting": self._dimension == 3, "ambient": light, "diffuse": 1 - light}
        return self._plotter.add_mesh(surface, **look, **lit)

    def _edges(self, surface: Any) -> Any:
        """The edges of a rigid body, and in space its outline as it is seen."""
        import pyvista

        ends = np.asarray(surface.field_data[EDGES]).reshape(-1, 2, 3)
        if self._dimension == 3:
            normals = np.asarray(surface.field_data[EDGE_NORMALS]).reshape(-1, 2, 3)
            bend = np.einsum("mi,mi->m", normals[:, 0], normals[:, 1])
            front = normals @ self._axes[2] > 0
            sharp = bend < surface.field_data[SHARP][0]
            ends = ends[sharp | (front[:, 0] != front[:, 1])]
        points = ends.reshape(-1, 3) + NEARER * self._far * self._axes[2]
        lines = np.insert(np.arange(len(points)).reshape(-1, 2), 0, 2, axis=1)
        return self._plotter.add_mesh(
            pyvista.PolyData(points, lines=lines.ravel()),
            color=EDGE,
            line_width=2 * self._line,
            lighting=False,
            render=False,
            reset_camera=False,
        )

    def _arrow(self, arrow: Any, colour: str) -> Any:
        """An arrow, drawn over the bodies."""
        actor = self._plotter.add_mesh(
            arrow, color=colour, lighting=False, render=False, reset_camera=False
        )
        # Nearer to the eye than all else: forces act inside of what they press together.
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, -66000.0)
        return actor

    def _add_floor(self, low: Array, high: Array, level: float, beyond: float) -> None:
        """The floor with lines on it, so that it is seen to move."""
        import pyvista

        spacing = rounded_down(float(np.max(high - low)) / 10)
        if self._dimension == 3:
            size = high[:2] - low[:2] + 2 * beyond
            across, deep = (round(length / spacing) for length in size)
            plane = pyvista.Plane(
                center=(*(0.5 * (low + high)[:2]), level),
                i_size=size[0],
                j_size=size[1],
                i_resolution=across,
                j_resolution=deep,
            )
            look = {"show_edges": True, "edge_color": "#c4c4c4", "line_width": self._line}
            self._plotter.add_mesh(plane, color="#efefef", lighting=False, **look)
            return
        count = math.ceil(beyond / spacing)
        wide = count * spacing
        below = [(x, y, -1e-3) for x, y in ((-wide, level - wide), (wide, level - wide))]
        above = [(x, level, -1e-3) for x in (wide, -wide)]
        band = pyvista.PolyData(np.array([*below, *above]), faces=np.array([4, 0, 1, 2, 3]))
        look = {"color": "#707070", "line_width": 1.5, "lighting": False}
        self._plotter.add_mesh(band, color=FLOOR, lighting=False)
        self._plotter.add_mesh(_hatch(level, spacing, count), **look)

    def close(self) -> None:
        """Free the window."""
        self._plotter.close()


def arrow(start: Array, direction: Array, length: float, *, unit: float) -> Any:
    """An arrow, as `pyvista.PolyData`, m.

    Its thickness and head are those of a unit length, unless it is shorter than its head.
    """
    import pyvista

    head = min(0.35 * unit, 0.6 * length)
    thick = min(0.035 * unit, 0.12 * head)  # also short ones are arrows, no dots
    return pyvista.Arrow(
        start=in_space(start),
        direction=in_space(direction),
        scale=length,
        tip_length=head / length,
        tip_radius=3.2 * thick / length,
        shaft_radius=thick / length,
        shaft_resolution=24,
        tip_resolution=24,
    )


def bars(links: Sequence[LinkFrames], frame: int, *, unit: float) -> list[tuple[Any, str]]:
    """What stands for links in a frame, `pyvista.PolyData` with their colours, m."""
    found = []
    for link in links:
        for line in link.lines(frame, unit):
            hue = LOOKS[int(link.states[frame])][1]
            found.append((bar(in_front(line[0]), in_front(line[1]), unit=unit), hue))
    return found


def bar(first: Array, second: Array, *, unit: float) -> Any:
    """A bar between two places in space, or a ball where they are one, as `pyvista.PolyData`."""
    import pyvista

    thick = 0.03 * unit
    if np.linalg.norm(second - first) < 2 * thick:
        return pyvista.Sphere(radius=2 * thick, center=0.5 * (first + second))
    return pyvista.Tube(pointa=first, pointb=second, radius=thick, n_sides=12)


def in_space(vector: Array) -> Array:
    """A vector of the plane or of space in space."""
    return np.pad(np.asarray(vector, dtype=float), (0, 3 - len(vector)))


def in_front(place: Array) -> Array:
    """A place in space, m; one of the plane a little before the bodies there."""
    found = in_space(place)
    found[2] += 0.01 * (len(place) == 2)
    return found


def _hatch(level: float, spacing: float, count: int) -> Any:
    """The line of the floor in the plane, and strokes below it."""
    import pyvista

    ends = [(-count * spacing, level, 0.0), (count * spacing, level, 0.0)]
    for k in range(-count, count + 1):
        ends += [(k * spacing, level, 0.0), ((k - 0.4) * spacing, level - 0.4 * spacing, 0.0)]
    lines = np.array([(2, k, k + 1) for k in range(0, len(ends), 2)]).ravel()
    return pyvista.PolyData(np.array(ends), lines=lines)
