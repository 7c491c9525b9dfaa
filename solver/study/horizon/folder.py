"""Names of what a study of horizons leaves in its folder."""

from __future__ import annotations

from solver.study.folder import StudyFolder

TABLE, TEXT, SUMMARY, PICTURE = "horizon.csv", "horizon.txt", "summary.json", "horizon.png"

FOLDER = StudyFolder(
    kind="study of horizons",
    same="the same scene, motion and differences",
    files=(TABLE, TEXT, SUMMARY, PICTURE),
)
