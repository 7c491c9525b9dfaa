"""The stage of a run: bodies, floor and forces, drawn by pyvista off screen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from solver.pictures.deformed import ABOVE, ASIDE, FLOOR
from solver.pictures.film.contact import State
from solver.pictures.film.encode import Pixels
from solver.pictures.film.take import Take
from solver.scene.time import rounded_down
from solver.types import Array

#: Colours of arrows and rigid bodies by state, and of platforms.
FORCE = {State.STICKS: "#2aa9ff", State.SLIPS: "#ff6a00", State.OPEN: "#2aa9ff"}
BODY = {State.STICKS: "#c9d3df", State.SLIPS: "#f6cf9b", State.OPEN: "#e8f4e4"}
PLATFORM = "#b5b5b5"

STRESS = "viridis"

#: Light that comes from everywhere, so that sides are not black.
AMBIENT = 0.4

#: An arrow is drawn no longer than this, over the one of the weight.
LONGEST = 3.0

#: Samples of a pixel, so that edges are smooth.
SAMPLES = 8


class Stage:
    """Draws the frames of one run."""

    def __init__(self, take: Take, size: tuple[int, int], low: Array, high: Array, limit: float):
        """Set up for pictures of a size (width, height) that show what lies between two corners.

        The stress limit is that of the last colour, Pa.
        """
        import pyvista

        self._take, self._limit, self._dimension = take, limit, len(low)
        self._plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size))
        self._plotter.enable_anti_aliasing("msaa", multi_samples=SAMPLES)
        self._plotter.set_background("white")
        self._floor = self._add_floor(low, high)
        surfaces = take.bodies.at(0)
        self._actors = [self._add_body(surface) for surface in surfaces]
        self._arrows = [self._add_arrow() for _ in take.blocks]
        names = take.bodies.names
        self._of_block = [
            names.index(block.name) if block.name in names else number
            for number, block in enumerate(take.run.scene.blocks)
        ]
        self._look(size, low, high)

    def _add_body(self, surface: Any) -> Any:
        """A body, coloured by its stress where it is meshed."""
        if self._has_stress(surface):
            return self._plotter.add_mesh(
                surface,
                scalars="von_mises",
                cmap=STRESS,
                clim=(0, self._limit),
                show_scalar_bar=False,
                show_edges=True,
                edge_color="#303030",
                edge_opacity=0.4,
                **self._light(),
                copy_mesh=True,
            )
        return self._plotter.add_mesh(
            surface,
            color=PLATFORM,
            show_edges=True,
            line_width=2,
            edge_color="#303030",
            **self._light(),
            copy_mesh=True,
        )

    def _light(self) -> dict[str, Any]:
        """Sides are told apart in space; in the plane colours are those of the legend."""
        if self._dimension == 2:
            return {"lighting": False}
        return {"lighting": True, "ambient": AMBIENT, "diffuse": 1 - AMBIENT}

    def _has_stress(self, surface: Any) -> bool:
        """Whether a body is meshed: a rigid one is a single cell, or its six sides."""
        return self._limit > 0 and "von_mises" in surface.cell_data and surface.n_cells > 6

    def _add_arrow(self) -> Any:
        """An arrow, drawn over the bodies."""
        import pyvista

        actor = self._plotter.add_mesh(pyvista.Sphere(radius=1e-9), color="black", lighting=False)
        # Nearer to the eye than all else: forces act inside of what they press together.
        mapper = actor.mapper
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, -66000.0)
        return actor

    def _add_floor(self, low: Array, high: Array) -> list[Any]:
        """The floor with lines on it, so that one sees it move."""
        import pyvista

        level, size = self._take.floor, float(np.max(high - low))
        spacing = rounded_down(size / 10)
        count = int(4 * size / spacing)
        if self._dimension == 3:
            middle = [spacing * round(value / spacing) for value in 0.5 * (low + high)[:2]]
            plane = pyvista.Plane(
                center=(*middle, level),
                i_size=count * spacing,
                j_size=count * spacing,
                i_resolution=count,
                j_resolution=count,
            )
            look = {"show_edges": True, "edge_color": "#c4c4c4", "lighting": False}
            return [self._plotter.add_mesh(plane, color="#efefef", **look)]
        wide = count * spacing
        below = [(x, y, -1e-3) for x, y in ((-wide, level - wide), (wide, level - wide))]
        above = [(x, level, -1e-3) for x in (wide, -wide)]
        band = pyvista.PolyData(np.array([*below, *above]), faces=np.array([4, 0, 1, 2, 3]))
        look = {"color": "#707070", "line_width": 1.5, "lighting": False}
        return [
            self._plotter.add_mesh(band, color=FLOOR, lighting=False),
            self._plotter.add_mesh(_hatch(level, spacing, count), **look),
        ]

    def _look(self, size: tuple[int, int], low: Array, high: Array) -> None:
        """Point the camera: at the plane, or as pictures in space are seen."""
        camera, middle, far = self._plotter.camera, 0.5 * (low + high), float(np.max(high - low))
        axes = np.eye(3)
        if self._dimension == 3:
            right = np.array([math.cos(ASIDE), math.sin(ASIDE), 0.0])
            level = math.cos(ABOVE) * np.array([math.sin(ASIDE), -math.cos(ASIDE), 0.0])
            eye = level + np.array([0.0, 0.0, math.sin(ABOVE)])
            axes = np.stack([right, np.cross(eye, right), eye])
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(len(low), -1).T
        seen = (corners - middle) @ axes[:2, : self._dimension].T
        half = np.abs(seen).max(axis=0)
        camera.SetParallelProjection(True)
        camera.SetFocalPoint(*_in_space(middle))
        camera.SetPosition(*(_in_space(middle) + 4 * far * axes[2]))
        camera.SetViewUp(*axes[1])
        camera.SetParallelScale(float(max(half[1], half[0] * size[1] / size[0])))

    def draw(self, frame: int) -> Pixels:
        """The picture of a frame."""
        take = self._take
        ground, surfaces = _in_space(take.ground[frame]), take.bodies.at(frame)
        for actor, surface in zip(self._actors, surfaces, strict=True):
            actor.mapper.SetInputData(surface)
            if self._has_stress(surface):
                surface.set_active_scalars("von_mises", preference="cell")
            actor.SetPosition(*ground)
        for number, (block, arrow) in enumerate(zip(take.blocks, self._arrows, strict=True)):
            state = block.states[frame]
            body = self._of_block[number]
            if not self._has_stress(surfaces[body]):
                self._actors[body].prop.color = BODY[state]
            arrow.prop.color = FORCE[state]
            shown = self._arrow(block.foot[frame], block.force[frame])
            arrow.SetVisibility(shown is not None)
            if shown is not None:
                arrow.mapper.SetInputData(shown)
                arrow.SetPosition(*ground)
        for actor in self._floor:
            actor.SetPosition(*ground)
        self._plotter.renderer.ResetCameraClippingRange()
        self._plotter.render()
        return np.asarray(self._plotter.screenshot(return_img=True))[:, :, :3].copy()

    def _arrow(self, foot: Array, force: Array) -> Any:
        """The arrow of a force over the weight; None for one too small to see."""
        import pyvista

        unit, length = self._take.arrow, float(np.linalg.norm(force))
        if length < 0.03:
            return None
        drawn = unit * min(length, LONGEST)
        head, thick = min(0.35 * unit, 0.6 * drawn), 0.035 * unit
        start = _in_space(foot)
        if self._dimension == 2:
            start[2] = 0.01
        return pyvista.Arrow(
            start=start,
            direction=_in_space(force),
            scale=drawn,
            tip_length=head / drawn,
            tip_radius=3.2 * thick / drawn,
            shaft_radius=thick / drawn,
            shaft_resolution=24,
            tip_resolution=24,
        )

    def close(self) -> None:
        """Free the window."""
        self._plotter.close()


def _in_space(vector: Array) -> Array:
    """A vector of the plane or of space in space."""
    return np.pad(np.asarray(vector, dtype=float), (0, 3 - len(vector)))


def _hatch(level: float, spacing: float, count: int) -> Any:
    """The line of the floor in the plane, and strokes below it."""
    import pyvista

    ends = [(-count * spacing, level, 0.0), (count * spacing, level, 0.0)]
    for k in range(-count, count + 1):
        ends += [(k * spacing, level, 0.0), ((k - 0.4) * spacing, level - 0.4 * spacing, 0.0)]
    lines = np.array([(2, k, k + 1) for k in range(0, len(ends), 2)]).ravel()
    return pyvista.PolyData(np.array(ends), lines=lines)
