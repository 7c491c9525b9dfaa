"""The script that opens the fields of a run in ParaView, as the block stands."""

from __future__ import annotations

SCRIPT = '''\
"""Opens this run in ParaView: paraview --script=open_in_paraview.py

The block is drawn true to scale (displacement added to the mesh, factor 1), coloured by von Mises
stress, with the surface that it stands on. Press play.
"""

from pathlib import Path

from paraview.simple import (
    ColorBy,
    GetActiveViewOrCreate,
    GetAnimationScene,
    GetColorTransferFunction,
    Line,
    PVDReader,
    Render,
    ResetCamera,
    Show,
    WarpByVector,
)

# ParaView does not always tell a script where it lies: then look into the current folder
here = Path(globals().get("__file__", "open_in_paraview.py")).resolve().parent
HALF_FLOOR = {half_floor!r}  # m

fields = PVDReader(FileName=str(here / "fields.pvd"))
view = GetActiveViewOrCreate("RenderView")
view.InteractionMode = "2D"

block = WarpByVector(Input=fields, Vectors=["POINTS", "displacement"], ScaleFactor=1.0)
shown = Show(block, view)
shown.Representation = "Surface With Edges"
ColorBy(shown, ("CELLS", "von_mises"))
shown.SetScalarBarVisibility(view, True)
shown.RescaleTransferFunctionToDataRange(False, True)
GetColorTransferFunction("von_mises").AutomaticRescaleRangeMode = "Grow and update every timestep"

floor = Show(Line(Point1=[-HALF_FLOOR, 0.0, 0.0], Point2=[HALF_FLOOR, 0.0, 0.0]), view)
floor.LineWidth = 3.0
floor.AmbientColor = floor.DiffuseColor = [0.2, 0.2, 0.2]

GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
ResetCamera(view)
Render(view)
'''


def paraview_script(half_floor: float) -> str:
    """Text of `open_in_paraview.py`.

    Args:
        half_floor: Half the length of the floor that is drawn, m.
    """
    return SCRIPT.replace("{half_floor!r}", repr(float(half_floor)))
