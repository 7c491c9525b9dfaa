"""Names of what a study of modes leaves in its folder."""

from __future__ import annotations

from solver.study.folder import StudyFolder

TABLE, TEXT, SUMMARY, PICTURE = "modes.csv", "modes.txt", "summary.json", "modes.png"

FOLDER = StudyFolder(
    kind="study of modes",
    same="the same scene and number of points",
    files=(TABLE, TEXT, SUMMARY, PICTURE),
)
