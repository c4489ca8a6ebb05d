"""Random scenes of forces and motions of the base: estimates and bounds of errors beside the errors, against far more modes.

`PYTHONPATH=bench python -m errors.loads [--scenes 300]` takes five minutes. BEAMWAVE_SEED sets the seed, BEAMWAVE
another program.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import load_scenes
import numpy as np
import xarray as xr
from workplace import Workplace

from . import PROGRAM, SEED, spread


def run_in(here: Workplace):
    def run(scene):
        here.scene("scene", scene)
        ended = here.beamwave("run", "scene.nml", "--quiet")
        if ended.returncode not in (0, 4):  # 4: not known to its end
            raise RuntimeError(ended.stderr)
        with xr.open_dataset(here.directory / "output/scene.nc") as ds:
            found = ds.load()
        (here.directory / "output/scene.nc").unlink()
        return found

    return run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=300, help="of each kind")
    scenes = parser.parse_args().scenes
    for kind in ("force", "base", "hub", "hub_base", "change"):
        rng = np.random.default_rng(SEED)
        with tempfile.TemporaryDirectory() as folder:
            run = run_in(Workplace(PROGRAM, Path(folder)))
            judged = [j for _ in range(scenes) for j in load_scenes.judge(run, load_scenes.draw(rng, kind), int(rng.choice(load_scenes.COUNTS)))]
        print(f"{kind}: {scenes} scenes")
        for quantity in load_scenes.QUANTITIES:
            print(f"  {quantity:15} {spread([j.estimate for j in judged if j.quantity == quantity])}")
        bounds = np.array([j.bound for j in judged if j.quantity == "displacement"])
        print(f"  bound over error: least {bounds.min():.2g}, median {np.median(bounds):.2g}")
        for j in sorted((j for j in judged if j.estimate < 1), key=lambda j: j.estimate)[:10]:
            print(f"  below: {j}")


if __name__ == "__main__":
    main()
