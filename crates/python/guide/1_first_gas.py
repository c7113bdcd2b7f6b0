# %% [markdown]
# # A first gas
#
# A scene says what is in the box at the start. Here: 1000 equal discs at temperature kT = 1 that
# cover 30 % of a periodic box of sides 1. Lengths, masses and times are in units of your choice.

# %%
import carom

gas = {"area_fraction": 0.3, "count": 1000, "mass": 1, "temperature": 1, "velocities": "maxwell"}
scene = carom.Scene(gas={**gas, "radius": 0.00977, "tags": ["gas"]}, seed=1)
scene

# %% [markdown]
# `area_fraction` and `count` exclude each other: the error says so, and names the entry.

# %%
try:
    carom.Simulation(scene)
except carom.SceneError as error:
    print(error)

# %%
del gas["area_fraction"]
scene = carom.Scene(gas={**gas, "radius": 0.00977, "tags": ["gas"]}, seed=1)
sim = carom.Simulation(scene)
sim.run(until=0.5)
print(sim, sim.collision_count, "collisions,", sim.overlapping_pairs, "overlapping pairs")

# %% [markdown]
# The state is NumPy arrays: copies at `sim.time`, in the order of insertion.

# %%
print(sim.positions.shape, sim.velocities.std(axis=0))

# %% [markdown]
# `show` gives the motion of the next contacts, as a picture that needs no network and no files.

# %%
picture = sim.show()
picture

# %% [markdown]
# A live view follows the simulation while it runs, in a notebook:
#
# ```python
# view = carom.live(sim)
# view.run(until=1.0, every=0.01)
# ```

# %% [markdown]
# ## Measures
#
# `carom.measures()` lists all. A measure begins now and samples at the interval `every`. Its table
# has units, standard errors from blocks of time, and the prediction of theory where there is one.

# %%
shells = sim.measure("pair-distribution", of="gas", every=0.02, max=0.08)
pressure = sim.measure("pressure", every=0.02)
sim.run(until=2.0)
for figure in pressure.figures.values():
    print(figure)

# %%
ax = shells.table.plot()

# %% [markdown]
# The pressure of hard discs is known (Liu 2021). The measured one agrees within its error.

# %%
measured = pressure.figures["pressure"]
assert abs(measured.value - measured.prediction) < 5 * measured.standard_error

# %% [markdown]
# ## Files
#
# `sim.save` writes the same checkpoint as the command `carom run`, and `carom.load` reads both.
# The scene is also a file for the command.

# %%
import pathlib
import tempfile

folder = pathlib.Path(tempfile.mkdtemp())
(folder / "gas.toml").write_text(scene.to_toml())
sim.save(folder / "checkpoint")
again = carom.load(folder / "checkpoint")
assert (again.positions == sim.positions).all()
