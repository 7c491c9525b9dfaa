"""Inspect a run in ParaView: pvpython look.py FOLDER ANSWER, by the script in the folder.

The answer, in JSON: times, names of the bodies, their bounds at some of the times, and how much is
drawn in pictures of two of them, which are left beside it.
"""

import json
import sys
from pathlib import Path

folder, answer = Path(sys.argv[1]), Path(sys.argv[2])
sys.argv[1:] = []
script = folder / "open_in_paraview.py"
opened = {"__file__": str(script), "__name__": "__main__"}
exec(compile(script.read_text(), script, "exec"), opened)

from paraview.simple import GetAnimationScene, Render, SaveScreenshot  # noqa: E402
from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: E402
from vtkmodules.vtkIOImage import vtkPNGReader  # noqa: E402

#: Numbers of the times that are looked at; pictures are made of the first two.
LOOKED_AT = (0, 60, 137, 200, 300)


def leaves(data, name):
    """The grids of a data set of VTK by the names of the blocks that they are in, outermost."""
    if not data.IsA("vtkMultiBlockDataSet"):
        yield name, data
        return
    for block in range(data.GetNumberOfBlocks()):
        known = data.GetMetaData(block)
        called = name or (known.Get(data.NAME()) if known else None)
        if data.GetBlock(block) is not None:
            yield from leaves(data.GetBlock(block), called)


def bounds_now():
    """Least and greatest place of each body, m."""
    found = {}
    for name, grid in leaves(opened["bodies"].GetClientSideObject().GetOutputDataObject(0), ""):
        low, high = grid.GetBounds()[::2], grid.GetBounds()[1::2]
        before = found.setdefault(name, [low, high])
        found[name] = [list(map(min, before[0], low)), list(map(max, before[1], high))]
    return found


def picture(file):
    """Make a picture; returns its pixels."""
    SaveScreenshot(str(file), opened["view"], ImageResolution=[1280, 720])
    reader = vtkPNGReader()
    reader.SetFileName(str(file))
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())


times = list(opened["fields"].TimestepValues)
seen, pictures = [], []
for number in LOOKED_AT:
    GetAnimationScene().AnimationTime = times[number]
    Render(opened["view"])
    opened["bodies"].UpdatePipeline(times[number])
    seen.append({"time": times[number], "bounds": bounds_now()})
    if len(pictures) < 2:
        pictures.append(picture(answer.with_name(f"{folder.name}-{number}.png")))
first, second = pictures
said = {
    "times": times,
    "seen": seen,
    "drawn": [float((pixels != 255).any(axis=1).mean()) for pixels in pictures],
    "differ": float((first != second).any(axis=1).mean()),
}
answer.write_text(json.dumps(said))
