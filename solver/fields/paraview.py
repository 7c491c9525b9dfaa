"""The script that opens the fields of a run in ParaView, the bodies where they stand."""

from __future__ import annotations

from pathlib import Path
from string import Template

from solver.fields.contacts import LONGEST, arrow_of_weight, largest_weight
from solver.fields.ground import floor_level, half_floor
from solver.scene import Scene

SCRIPT = Template('''\
"""Opens this run in ParaView: paraview --script=open_in_paraview.py

All bodies are drawn true to scale (displacement added to the mesh, factor 1),
$coloured, above the floor.
Arrows are contact forces; no larger ones are drawn than of $longest times the largest weight.
Press play.
A film: pvpython open_in_paraview.py film.avi (or film.png: a picture of each time)
"""

import sys
from pathlib import Path

from paraview.simple import (
    AnnotateTime,
    Calculator,
    ColorBy,
    ExtractBlock,
    GetActiveCamera,
    GetActiveView,
    GetActiveViewOrCreate,
    GetAnimationScene,
    GetColorTransferFunction,
    GetScalarBar,
    Glyph,
    Line,
    OpenDataFile,
    Plane,
    Render,
    ResetCamera,
    SaveAnimation,
    Show,
    WarpByVector,
)

# ParaView does not always tell a script where it lies: then look into the current folder
here = Path(globals().get("__file__", "open_in_paraview.py")).resolve().parent
HALF_FLOOR, LEVEL = $half_floor, $level  # m
WEIGHT, ARROW = $weight, $arrow  # the largest weight, N, and the length of its arrow, m
DARK = [0.15, 0.15, 0.15]

fields = OpenDataFile(str(here / "fields.pvd"))
alone = GetActiveView() is None  # without a window, whose views have their sizes
view = GetActiveViewOrCreate("RenderView")
if alone:
    view.ViewSize = [1280, 720]
view.UseColorPaletteForBackground = 0
view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = DARK
$camera

bodies = WarpByVector(Input=fields, Vectors=["POINTS", "displacement"], ScaleFactor=1.0)
shown = Show(bodies, view)
shown.Representation = "$look"
shown.EdgeColor = [0.35, 0.35, 0.35]
$clear$links
$colours

contacts = ExtractBlock(Input=fields, Selectors=["//contacts"])
drawn = Calculator(Input=contacts, AttributeType="Point Data", ResultArrayName="drawn")
drawn.Function = f"force*min(1, {$longest * WEIGHT}/max(mag(force), 1e-300))"
arrows = Glyph(Input=drawn, GlyphType="Arrow", GlyphMode="All Points", ScaleFactor=ARROW / WEIGHT)
arrows.OrientationArray = arrows.ScaleArray = ["POINTS", "drawn"]
forces = Show(arrows, view)
forces.ColorArrayName = [None, ""]
forces.AmbientColor = forces.DiffuseColor = [0.16, 0.66, 1.0]

$floor
ground = Show(floor, view)
ground.LineWidth = 3.0
ground.AmbientColor = ground.DiffuseColor = $grey

clock = Show(AnnotateTime(Format="t = {time:.3f} s"), view)
clock.Color = DARK
clock.FontSize = 20

GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
# The bodies decide what is seen, not the floor, with room for them to lie down
ground.Visibility = 0
ResetCamera(view)
GetActiveCamera().Zoom(0.7)
ground.Visibility = 1
Render(view)

films = [word for word in sys.argv[1:] if word.endswith((".avi", ".png"))]
if films:
    SaveAnimation(films[0], view, ImageResolution=[1280, 720], FrameRate=25)
''')

BY_STRESS = """\
ColorBy(shown, ("CELLS", "von_mises"))
shown.RescaleTransferFunctionToDataRange(False, True)
colours = GetColorTransferFunction("von_mises")
colours.AutomaticRescaleRangeMode = "Grow and update every timestep"
bar = GetScalarBar(colours, view)
bar.Title, bar.ComponentTitle = "von Mises stress (Pa)", ""
bar.WindowLocation = "Upper Right Corner"  # clear of the floor
bar.TitleColor = bar.LabelColor = DARK
bar.TitleFontSize = bar.LabelFontSize = 16
shown.SetScalarBarVisibility(view, True)"""

BY_BODY = 'ColorBy(shown, ("FIELD", "vtkBlockColors"))'

#: From the front, a little from the right and from above.
CAMERA_3D = """\
view.CameraPosition, view.CameraFocalPoint = [0.4, -0.85, 0.34], [0.0, 0.0, 0.0]
view.CameraViewUp = [0.0, 0.0, 1.0]"""

LINE = "floor = Line(Point1=[-HALF_FLOOR, LEVEL, 0.0], Point2=[HALF_FLOOR, LEVEL, 0.0])"

PLANE = """\
floor = Plane(
    Origin=[-HALF_FLOOR, -HALF_FLOOR, LEVEL],
    Point1=[HALF_FLOOR, -HALF_FLOOR, LEVEL],
    Point2=[-HALF_FLOOR, HALF_FLOOR, LEVEL],
)"""


def write_script(folder: Path, scene: Scene, *, stress: bool) -> None:
    """Write `open_in_paraview.py` for the run of a scene.

    Bodies are coloured by their `stress` where one is elastic, else each in a colour. They have the
    edges of their cells, but for rigid shapes, whose faces are cut into triangles.
    """
    spatial = scene.dimension == 3
    edges = all(b.model != "rigid" or b.shape.solid is None for b in scene.blocks)
    text = SCRIPT.substitute(
        look="Surface With Edges" if edges else "Surface",
        clear="" if stress or not spatial else "shown.Opacity = 0.6  # for the arrows in them\n",
        links="shown.LineWidth = 3.0  # of links" if scene.links else "",
        half_floor=repr(half_floor(scene)),
        level=repr(floor_level(scene)),
        coloured="coloured by von Mises stress" if stress else "each in a colour of its own",
        colours=BY_STRESS if stress else BY_BODY,
        camera=CAMERA_3D if spatial else 'view.InteractionMode = "2D"',
        floor=PLANE if spatial else LINE,
        weight=repr(largest_weight(scene)),
        arrow=repr(arrow_of_weight(scene)),
        longest=f"{LONGEST:g}",
        grey=[0.85, 0.85, 0.85] if spatial else [0.2, 0.2, 0.2],
    )
    (folder / "open_in_paraview.py").write_text(text, encoding="utf-8")
