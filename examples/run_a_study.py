"""How often does a driver collide, and how often a connected car? Varied runs, resumed where they stopped."""

import argparse
from pathlib import Path

from tqdm import tqdm

from cca_core.plot import plot_study
from cca_core.sim import EGO_TYPES, ParameterRanges, Study, run_study

# On many machines: run_study(study, path, executor=Client(...).get_executor()) with Dask's Client.


def main() -> None:
    """Drive, or drive on."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default="eebl")
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--out", type=Path, default=Path("out"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    study = Study(parameters=ParameterRanges(scenario=args.scenario), runs=args.runs)
    with tqdm(total=study.target_runs, unit="run", disable=None) as bar:

        def progress(done: int, wanted: int) -> None:
            bar.update(done - bar.n)

        table = run_study(study, args.out / f"study_{args.scenario}.db", progress=progress)
    table.write_csv(args.out / f"study_{args.scenario}.csv")
    for ego in EGO_TYPES:
        rate = table.rate(ego)
        print(
            f"{ego:6} hits in {rate.n_events} of {rate.n} avoidable runs: {rate.ci_low:.1%} to {rate.ci_high:.1%}"
        )
    plot_study([table], bins=3).savefig(args.out / f"study_{args.scenario}.png", dpi=120)


if __name__ == "__main__":
    main()
