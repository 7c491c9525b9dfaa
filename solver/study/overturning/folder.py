"""Names of what a study of overturning leaves in its folder."""

from __future__ import annotations

from solver.study.folder import StudyFolder

TABLE, TEXT, SUMMARY = "overturning.csv", "overturning.txt", "summary.json"
PICTURE, OVER_RESTITUTION = "overturning.png", "restitution.png"

FOLDER = StudyFolder(
    kind="study of overturning",
    same="the same scene, amplitudes and samples",
    files=(TABLE, TEXT, SUMMARY, PICTURE, OVER_RESTITUTION),
)
