# %% [markdown]
# # Your own molecule
#
# A molecule is any rigid union of discs, called atoms. There are names for some shapes, and lists
# of atoms for all others. Atoms may overlap; each adds its own mass.

# %%
import carom
import numpy as np

boomerang = carom.Molecule(
    [(0.02 * i, 0.0, 0.01, 1.0) for i in range(4)] + [(0.0, 0.02 * i, 0.01, 1.0) for i in range(1, 4)]
)
print(boomerang, "area", boomerang.area, "moment of inertia", boomerang.moment_of_inertia)

# %% [markdown]
# ## What theory says
#
# A small disc cannot touch all of the outline: the arcs that it can touch are exact. From them
# follow the share of each atom in the contacts with an ideal gas, and the mean path of one disc
# between two contacts with the fixed molecule.

# %%
probe = 0.01
for arc in boomerang.exposed_arcs(probe)[:3]:
    print(arc)
print("shares of the atoms:", boomerang.atom_shares(probe).round(3))

# %% [markdown]
# ## Does a run agree?
#
# One disc around the fixed molecule: the mean path between contacts is π (A − A_excluded) / P. The
# paths of a chaotic billiard scatter, so that 20 000 contacts give it to about one per cent.

# %%
scene = carom.Scene(molecule=boomerang.at(0.5, 0.5, tags="target", fixed=True))
sim = carom.Simulation(scene)
sim.add(carom.Molecule.disc(probe), [0.1, 0.13], velocity=[np.cos(1.0), np.sin(1.0)])
hits = sim.collisions(until=7000.0)
path = np.diff(hits["time"]).mean()  # The speed is 1.
predicted = boomerang.mean_free_path(area=1.0, probe=probe)
print(f"{len(hits)} contacts, mean path {path:.4f}, predicted {predicted:.4f}")
assert abs(path / predicted - 1) < 0.1

# %%
shares = np.bincount(hits["atoms"][:, 0], minlength=len(boomerang)) / len(hits)
assert np.abs(shares - boomerang.atom_shares(probe)).max() < 0.05

# %% [markdown]
# ## A free molecule in a gas
#
# `on_collision` calls a function after each collision of two tags. It may read and edit the
# simulation. Here the molecule catches ten discs, which vanish.

# %%
sim = carom.Simulation(
    carom.Scene(
        molecule=boomerang.at(0.5, 0.5, tags="hunter"),
        gas={"radius": 0.01, "mass": 1, "temperature": 1, "count": 400, "tags": ["gas"]},
    )
)


@sim.on_collision(between=("hunter", "gas"))
def catch(hit):
    if len(sim) > 391:
        sim.remove([hit.ids[1]])


sim.run(until=2.0)
print(sim)
assert len(sim) == 391

# %% [markdown]
# ## Detection alone
#
# `first_contact` answers for many pairs at once when two molecules in free flight first touch.

# %%
angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
disc = carom.Molecule.disc(probe)
found = carom.first_contact(
    boomerang,
    disc,
    separation=0.3 * np.column_stack([np.cos(angles), np.sin(angles)]),
    velocity=-np.column_stack([np.cos(angles), np.sin(angles)]),
    angular_velocities=[5.0, 0.0],
)
print(found.time.round(4), found.atoms[:, 0])
assert np.isfinite(found.time).any()
