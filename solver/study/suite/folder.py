"""Names of what a suite leaves in its folder."""

from __future__ import annotations

from solver.study.folder import StudyFolder

RUNS = "runs"
TABLE, TEXT, SUMMARY, PICTURE = "suite.csv", "suite.txt", "summary.json", "suite.png"
FRAGILITY, FRAGILITY_TEXT = "fragility.csv", "fragility.txt"
CURVES, DISTRIBUTIONS = "fragility.png", "peaks.png"

FOLDER = StudyFolder(
    kind="suite",
    same="the same scene, motions and options",
    files=(TABLE, TEXT, SUMMARY, PICTURE, FRAGILITY, FRAGILITY_TEXT, CURVES, DISTRIBUTIONS),
    folders=(RUNS,),
)
