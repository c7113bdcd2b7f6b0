# %% [markdown]
# # Diffusion with error bars, and the price of accuracy
#
# ## Replicas
#
# Replicas of a scene differ in their random numbers alone. They run on all cores, and their sums
# are merged: means have errors from the blocks of all runs, and no order changes a digit.

# %%
import time

import carom
import numpy as np

scene = carom.Scene(
    gas={"radius": 0.02, "mass": 1, "temperature": 1, "velocities": "maxwell", "count": 200, "tags": ["gas"]},
    run={"until": 4.0, "sample_interval": 0.02, "measure_from": 0.5},
    seed=11,
)
vacf = {"kind": "correlation", "of": "gas", "max": 0.5}
found = carom.replicas(scene, 4, measures=[vacf])
print(found, found.runs)

# %%
for figure in found.figures.values():
    print(figure)

# %% [markdown]
# Each table has the columns of the chart, with errors and predictions.

# %%
for table in found.values():
    print(table, table.units)
ax = next(iter(found.values())).plot()

# %% [markdown]
# One replica has larger errors than four.

# %%
one = carom.run(scene, measures=[vacf])
name = next(name for name, figure in one.figures.items() if figure.standard_error)
print(one.figures[name], "|", found.figures[name])

# %% [markdown]
# ## The price of accuracy
#
# The default detector misses no contact. Other detectors are models or approximations; a run with
# them tells what they get wrong. Here bounding circles take the place of tees.

# %%
tees = {"shape": "tee", "atom_radius": 0.01, "atom_mass": 1, "energy": 1, "count": 100, "tags": ["tee"]}
prices = {}
for detector in ("exact", "golden-secant", "bounding-circles"):
    sim = carom.Simulation(carom.Scene(gas=tees, seed=2), detector=detector)
    begun = time.perf_counter()
    sim.run(until=2.0)
    prices[detector] = sim.collision_count
    seconds = time.perf_counter() - begun
    print(f"{detector:17} {sim.collision_count:6} collisions, {sim.overlapping_pairs} overlaps, {seconds:.2f} s")

# %% [markdown]
# Bounding circles collide more often than the molecules in them.

# %%
assert prices["bounding-circles"] > prices["exact"]
assert np.isfinite(found.figures[name].value)
