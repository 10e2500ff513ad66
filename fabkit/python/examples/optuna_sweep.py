"""Let Optuna look for designs: see more of the surface, and see it finer.

    pip install "fabkit-cad" optuna
    python optuna_sweep.py out 100

Writes the tables and the report of all trials into the folder.
"""

import sys

import optuna

import fabkit

PLAN = {
    "sensor": "rtac0",
    "sample": 1,
    "axes": {
        "camera.depth": {"from": "6 mm", "to": "7.4 mm"},
        "camera.field_of_view": {"from": "120 deg", "to": "175 deg"},
    },
    "metrics": ["camera", "calibration"],
    "constraints": ["camera_position_sigma_mm < 0.05"],
    "objectives": {"coverage": "max", "mm_per_px_median": "min"},
}


def main(out: str, trials: int) -> None:
    """Ask, tell, and write it all down."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    explorer = fabkit.sweep.Explorer(PLAN)
    directions = [f"{word}imize" for word in explorer.plan.objectives.values()]
    study = optuna.create_study(
        directions=directions, sampler=optuna.samplers.NSGAIISampler(seed=1)
    )
    for _ in range(trials):
        trial = study.ask()
        row = explorer.tell(explorer.ask(trial))
        values = explorer.objectives(row)
        if values is None:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
        else:
            study.tell(trial, values)
    sweep = explorer.save(out)
    print(f"{sweep.folder}: {sweep.variants} trials, {sweep.pareto} on the Pareto front")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
