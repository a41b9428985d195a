"""Collision rates of a driver, a sensor and a connected car, from sampled runs that can be resumed."""

import argparse
from pathlib import Path

from tqdm import tqdm

from cca_core.plot import plot_study
from cca_core.sim import ParameterRanges, Study, run_study

# on many machines: run_study(study, path, executor=Client(...).get_executor()) with Dask's Client


def main() -> None:
    """Run the study, or resume it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default="eebl")
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--out", type=Path, default=Path("out"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    study = Study(parameters=ParameterRanges(scenario=args.scenario), runs=args.runs)
    with tqdm(total=study.target_runs, unit="run", disable=None) as bar:

        def progress(done: int, target: int) -> None:
            bar.update(done - bar.n)

        table = run_study(study, args.out / f"study_{args.scenario}.db", progress=progress)
    table.write_csv(args.out / f"study_{args.scenario}.csv")
    print(table)
    plot_study([table], bins=3).savefig(args.out / f"study_{args.scenario}.png", dpi=120)


if __name__ == "__main__":
    main()
