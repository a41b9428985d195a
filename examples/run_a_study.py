"""How often does a driver collide, and how often a connected car? Varied runs, resumed where they stopped."""

import argparse
from pathlib import Path

from tqdm import tqdm

from cca_core.plot import plot_study
from cca_core.sim import EGOS, Study, Variation, run_study

# On many machines: run_study(study, path, executor=Client(...).get_executor()) with Dask's Client.


def main() -> None:
    """Drive, or drive on."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default="eebl")
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--out", type=Path, default=Path("out"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    study = Study(variation=Variation(scenario=args.scenario), runs=args.runs)
    with tqdm(total=study.wanted, unit="run") as bar:

        def progress(done: int, wanted: int) -> None:
            bar.update(done - bar.n)

        table = run_study(study, args.out / f"study_{args.scenario}.jsonl", progress=progress)
    table.write_csv(args.out / f"study_{args.scenario}.csv")
    for ego in EGOS:
        rate = table.rate(ego)
        print(f"{ego:6} hits in {rate.hits} of {rate.n} avoidable runs: {rate.low:.1%} to {rate.high:.1%}")
    plot_study([table], bins=3).savefig(args.out / f"study_{args.scenario}.png", dpi=120)


if __name__ == "__main__":
    main()
