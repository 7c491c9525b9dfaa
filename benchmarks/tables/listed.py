"""What tables and pictures there are, which commands make them, and what decides them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

#: What every run depends on: what a scene means where it says nothing, and how runs are read.
RUN = (
    *("solver/history", "solver/law", "solver/results", "solver/scene", "solver/scheme"),
    *("solver/run/simulate.py",),
)
#: What decides the answers of rigid blocks without meshes, of meshed bodies, and of both.
RIGID = (*RUN, "solver/rigid", "solver/run/rigid.py")
MESHED = (
    *(*RUN, "geometry", "solver/bodies", "solver/build", "solver/contact", "solver/stepping"),
    "solver/run/meshed.py",
)
ALL = tuple(dict.fromkeys((*MESHED, *RIGID)))

#: Ground motions, and the answers to compare with.
MOTION = ("solver/excitation",)
ANSWER = ("solver/reference",)

OWN = "{own}"
"""In a command: a folder of its own, which is kept until everything is done."""

DEMO = "demos/free_rocking/scene.toml"
DAMPING = "solver/study/damping"
SUITE = "solver/study/suite"
PICTURES = "docs/pictures"
ERRORS = "benchmarks/error_runtime"


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Tables and pictures that a command makes, or some commands one after the other.

    Attributes:
        commands: The first word is `rockslip` or `python3`; `{own}` is a folder of their own.
        code: Files and folders of the repository that decide the numbers. What draws is not among
            them, nor what only checks, tells or times.
        files: Where each file is kept in the repository, and what the commands call it in their
            own folder; the same name where they write it in place.
        minutes: Of processor time, about, until it has been measured.
        timed: Whether it says how long something takes: it wants a machine that does nothing else,
            and grows too old with the versions, whatever has changed.
        grows: Whether the command keeps the rows of a table that is there, to go on with it.
        outside: What it needs that is not in the repository; such are never made by `make tables`.
    """

    commands: tuple[str, ...]
    code: tuple[str, ...]
    files: Mapping[str, str] = field(default_factory=dict)
    minutes: float = 1.0
    timed: bool = False
    grows: bool = False
    outside: str = ""


def _script(
    name: str,
    code: tuple[str, ...],
    *pictures: str,
    minutes: float,
    timed: bool = False,
) -> Evidence:
    """A benchmark that writes the table of its name, in place."""
    script = f"benchmarks/{name}.py"
    kept = (f"benchmarks/{name}.csv", *pictures)
    return Evidence(
        commands=(f"python3 {script}",),
        code=(script, *code),
        files={file: file for file in kept},
        minutes=minutes,
        timed=timed,
    )


def _demo(script: str, picture: str, code: tuple[str, ...], minutes: float) -> Evidence:
    """A demo that draws a picture into its folder."""
    scene = f"{script.rpartition('/')[0]}/scene.toml"
    return Evidence(
        commands=(f"python3 {script} --output {OWN}",),
        code=(script, scene, *code),
        files={f"{PICTURES}/{picture}": picture},
        minutes=minutes,
    )


def _errors(name: str, code: tuple[str, ...], minutes: float) -> Evidence:
    """Error against run time of one scene; Hertz's contact has none."""
    scene = f"benchmarks/scenes/{name}.toml"
    picture = f"{PICTURES}/error_{name}.png"
    kept = (*(f"benchmarks/work_precision/{name}.{kind}" for kind in ("csv", "txt")), picture)
    own = ("benchmarks/hertz.py", "benchmarks/verification") if name == "hertz" else (scene,)
    return Evidence(
        commands=(f"python3 benchmarks/work_precision.py {name}",),
        code=(ERRORS, "benchmarks/work_precision.py", *own, *code),
        files={file: file for file in kept},
        minutes=minutes,
        timed=True,
    )


EVIDENCE: dict[str, Evidence] = {
    "adaptive_steps": _script("adaptive_steps", ALL, minutes=60),
    "block_on_platform": _script("block_on_platform", (*ALL, *MOTION, *ANSWER), minutes=10),
    "damped_steps": _script("damped_steps", (*MESHED, *ANSWER, DEMO), minutes=1),
    "energy_grid": _script("energy_grid", (*MESHED, DEMO), minutes=60),
    # What a feature costs is nothing that a change of code leaves as it was: it goes by its age.
    "feature_cost": _script("feature_cost", (), minutes=5, timed=True),
    "full_newton": Evidence(
        commands=("python3 benchmarks/full_newton.py --cases 2-D-5k 2-D-50k 3-D-50k",),
        code=("benchmarks/full_newton.py", "benchmarks/newton", *MESHED),
        files={"benchmarks/full_newton.csv": "benchmarks/full_newton.csv"},
        minutes=3,
        timed=True,
    ),
    "hertz": _script("hertz", (*MESHED, "benchmarks/verification"), minutes=3),
    "landing_on_bed": _script("landing_on_bed", (*MESHED, DEMO), minutes=3),
    "ranks": _script("ranks", (*ALL, *MOTION), minutes=5),
    "rigid_rocking": _script("rigid_rocking", (*RIGID, *ANSWER), minutes=1, timed=True),
    "scaling": replace(
        _script("scaling", (), minutes=14, timed=True),
        commands=("python3 benchmarks/scaling.py --long",),
        grows=True,
    ),
    "sensitivity": _script("sensitivity", ("benchmarks/adaptive_steps.py", *ALL), minutes=15),
    "steady_rocking": _script("steady_rocking", (*MESHED, *MOTION, *ANSWER), minutes=3),
    "stiffness_limit": _script("stiffness_limit", (*ALL, *ANSWER, DEMO), minutes=5),
    "suite_cost": _script(
        "suite_cost",
        (*ALL, *MOTION, *ANSWER),
        f"{PICTURES}/suite_cost.png",
        minutes=10,
        timed=True,
    ),
    "t1_rigid": _errors("t1_rigid", (*RIGID, *ANSWER), 0.2),
    "t1_elastic": _errors("t1_elastic", (*ALL, *ANSWER), 8),
    "t2": _errors("t2", (*ALL, *MOTION, *ANSWER), 7),
    "t3": _errors("t3", (*ALL, *MOTION, *ANSWER), 2),
    "space": _errors("space", (*ALL, *MOTION, *ANSWER, "benchmarks/scenes/t3.toml"), 4),
    "plate": _errors("plate", (*ALL, *MOTION, *ANSWER), 8),
    "rocking_platform": _errors("rocking_platform", (*ALL, *MOTION, *ANSWER), 1),
    "error_hertz": _errors("hertz", MESHED, 1),
    "stability": Evidence(
        commands=(f"rockslip study stability -o {OWN}",),
        code=("benchmarks/stability", *ALL, *MOTION),
        files={
            "benchmarks/stability.csv": "stability.csv",
            f"{PICTURES}/stability.png": "stability.png",
        },
        minutes=60,
    ),
    "damping": Evidence(
        commands=(f"rockslip study damping {DEMO} -o {OWN}",),
        code=(DEMO, DAMPING, *MESHED),
        files={
            "benchmarks/damping.csv": "damping.csv",
            f"{PICTURES}/damping.png": "damping.png",
        },
        minutes=60,
    ),
    "damping_beta": Evidence(
        commands=(
            f"rockslip study damping {DEMO} --of beta=0,1e-6,3e-6,1e-5,3e-5,1e-4,3e-4,1e-3 "
            f"--at mesh=1,2 -o {OWN}",
        ),
        code=(DEMO, DAMPING, *MESHED),
        files={
            "benchmarks/damping_beta.csv": "damping.csv",
            f"{PICTURES}/damping_beta.png": "damping.png",
        },
        minutes=20,
    ),
    "damping_histories": Evidence(
        commands=(
            f"rockslip study damping {DEMO} --of beta=1e-6,1e-5,3.65e-5,1e-4,1e-3 "
            f"--histories -o {OWN}",
        ),
        code=(DEMO, DAMPING, *MESHED),
        files={f"{PICTURES}/damping_histories.png": "histories_beta.png"},
        minutes=4,
    ),
    "damping_calibration": Evidence(
        commands=(f"rockslip study damping {DEMO} --target restitution=0.936 -o {OWN}",),
        code=(DEMO, DAMPING, *MESHED),
        files={f"{PICTURES}/damping_calibration.png": "calibration.png"},
        minutes=1,
    ),
    "suite_synthetic": Evidence(
        commands=(f"python3 demos/suite/platform_suite.py --output {OWN}",),
        code=("demos/suite/scene.toml", SUITE, *MESHED, *MOTION, *ANSWER),
        files={
            "benchmarks/suite_synthetic.csv": "suite.csv",
            f"{PICTURES}/suite_peak_drifts.png": "peak_drifts.png",
        },
        minutes=35,
    ),
    "suite_plate": Evidence(
        commands=(f"python3 demos/suite/platform_suite.py --plate --output {OWN}",),
        code=("demos/suite/plate.toml", SUITE, *MESHED, *MOTION, *ANSWER),
        files={"benchmarks/suite_plate.csv": "suite.csv"},
        minutes=27,
    ),
    "suite_recorded": Evidence(
        commands=(f"python3 demos/suite/platform_suite.py --motions records --output {OWN}",),
        code=("demos/suite/scene.toml", SUITE, *MESHED, *MOTION, *ANSWER),
        files={"benchmarks/suite_recorded.csv": "suite.csv"},
        minutes=45,
        outside="thirty records of strong motions, which may not be passed on",
    ),
    "ensemble": Evidence(
        commands=(
            "rockslip study suite demos/ensemble/scene.toml --count 100 --levels 0.5 "
            f"--engines rigid,ode,elastic -o {OWN}",
        ),
        code=("demos/ensemble/scene.toml", SUITE, *ALL, *MOTION, *ANSWER),
        files={
            "benchmarks/ensemble.csv": "suite.csv",
            f"{PICTURES}/ensemble_peaks.png": "peaks.png",
        },
        minutes=180,
    ),
    "fragility": Evidence(
        commands=(
            "rockslip study suite demos/ensemble/scene.toml --count 60 --levels 0.3:0.7:5 "
            f"--engines rigid,ode --set time.step=2e-3 -o {OWN}",
        ),
        code=("demos/ensemble/scene.toml", SUITE, *RIGID, *MOTION, *ANSWER),
        files={f"{PICTURES}/fragility.png": "fragility.png"},
        minutes=15,
    ),
    "horizon": Evidence(
        commands=(
            "rockslip study horizon demos/ensemble/scene.toml "
            "--set motion.kind=synthetic motion.scale=3 --differences 1e-9,1e-6,1e-3 "
            f"-o {OWN}",
        ),
        code=("demos/ensemble/scene.toml", "solver/study/horizon", *RIGID, *MOTION),
        files={f"{PICTURES}/horizon.png": "horizon.png"},
        minutes=1,
    ),
    "inertia": Evidence(
        commands=(f"rockslip study inertia demos/inertia/scene.toml -o {OWN}",),
        code=("demos/inertia/scene.toml", "solver/study/inertia", *MOTION, *ANSWER),
        files={f"{PICTURES}/inertia_lambda.png": "lambda.png"},
        minutes=5,
    ),
    "inertia_elements": Evidence(
        commands=(
            "rockslip study inertia demos/suite/scene.toml --of period=0.5,1 "
            f"friction=0.1,0.2,0.3 --by rigid elements --count 30 -o {OWN}",
        ),
        code=("demos/suite/scene.toml", "solver/study/inertia", *ALL, *MOTION, *ANSWER),
        files={"benchmarks/inertia_elements.csv": "inertia.csv"},
        minutes=17,
    ),
    "inertia_locked_stack": Evidence(
        commands=(
            "rockslip study inertia demos/inertia/locked_stack.toml --of period=0.5,1 "
            f"aspect=0.5,4.251 --by rigid -o {OWN}",
        ),
        code=("demos/inertia/locked_stack.toml", "solver/study/inertia", *RIGID, *MOTION, *ANSWER),
        files={"benchmarks/inertia_locked_stack.csv": "inertia.csv"},
        minutes=2,
    ),
    "modes": Evidence(
        commands=(f"rockslip study modes demos/modes/scene.toml -o {OWN}",),
        code=("demos/modes/scene.toml", "solver/study/modes", *ALL, *MOTION, *ANSWER),
        files={f"{PICTURES}/modes.png": "modes.png"},
        minutes=2,
    ),
    "overturning": Evidence(
        commands=(
            "rockslip study overturning demos/overturning/scene.toml --restitution 0.936 "
            f"--ode 1,2,3,4,5,6,8 --elastic 2,4,6 -o {OWN}",
        ),
        code=("demos/overturning/scene.toml", "solver/study/overturning", *ALL, *MOTION, *ANSWER),
        files={f"{PICTURES}/overturning.png": "overturning.png"},
        minutes=15,
    ),
    "overturning_restitution": Evidence(
        commands=(
            "rockslip study overturning demos/overturning/scene.toml --pulses one_sine "
            "--frequencies 3,5,6 --restitution 0.86,0.88,0.9,0.92,0.94,0.96,0.98 "
            f"--rounds 0 -o {OWN}",
        ),
        code=("demos/overturning/scene.toml", "solver/study/overturning", *RIGID, *MOTION),
        files={f"{PICTURES}/overturning_restitution.png": "restitution.png"},
        minutes=1,
    ),
    "tutorial_histories": Evidence(
        commands=(
            f"rockslip run demos/pedestal/scene.toml -o {OWN}/rigid",
            "rockslip run demos/pedestal/scene.toml --set block.model=elastic output.twin=false "
            f"-o {OWN}/elastic",
            f"rockslip plot {OWN}/rigid {OWN}/elastic -o {OWN}/both",
        ),
        code=("demos/pedestal/scene.toml", *ALL, *MOTION),
        files={f"{PICTURES}/tutorial_histories.png": "both/overlay.png"},
        minutes=2,
    ),
    "tutorial_fragility": Evidence(
        commands=(
            "rockslip study suite demos/pedestal/scene.toml --set time.step=1e-3 "
            f"--levels 0.42,0.6,0.8,1 --engines rigid -o {OWN}",
        ),
        code=("demos/pedestal/scene.toml", SUITE, *RIGID, *MOTION),
        files={f"{PICTURES}/tutorial_fragility.png": "fragility.png"},
        minutes=2,
    ),
    "statue": Evidence(
        commands=(
            f"rockslip run demos/statue/scene.toml -o {OWN}/run",
            f"rockslip animate {OWN}/run --from 0.8 --until 3.6 --width 600 -o {OWN}/statue.gif",
        ),
        code=("demos/statue/scene.toml", *MESHED, *MOTION),
        files={f"{PICTURES}/statue.gif": "statue.gif"},
        minutes=3,
    ),
    "free_rocking": _demo(
        "demos/free_rocking/free_rocking.py", "free_rocking.png", (*MESHED, *ANSWER), 2
    ),
    "foundation": _demo(
        "demos/foundation/block_on_foundation.py", "foundation.png", (*MESHED, *ANSWER), 3
    ),
    "yard": _demo("demos/yard/container_yard.py", "yard.png", (*ALL, *MOTION), 25),
    "laboratory": _demo("demos/laboratory/laboratory_model.py", "laboratory.png", ALL, 10),
    # The names of the packages stand in the script; tests hold the tree to them.
    "architecture": Evidence(
        commands=("python3 docs/draw_architecture.py",),
        code=("docs/draw_architecture.py",),
        files={f"{PICTURES}/architecture.png": f"{PICTURES}/architecture.png"},
        minutes=0.1,
    ),
}
