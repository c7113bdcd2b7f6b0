"""Uses each part of the interface, for mypy --strict and pyright; it is not run."""

from concurrent.futures import ThreadPoolExecutor

import carom
import numpy as np

scene = carom.Scene(gas={"radius": 0.01, "mass": 1, "temperature": 1, "count": 10, "tags": ["gas"]}, seed=1)
sim = carom.Simulation(scene, detector="exact", threads=1)
shells: carom.Measure = sim.measure("pair-distribution", of="gas", every=0.02, max=0.06)
sim.run(until=2.0, progress=True)


@sim.on_collision(between=("tee", "gas"))
def heard(hit: carom.Collision) -> None:
    print(hit.time + float(hit.impulse[0]), hit.ids[0] + 1, hit.positions, hit.velocities_before[0])


rows = sim.collisions(until=3.0)
mean = np.diff(rows["time"]).mean()
table: carom.Table = shells.table + shells.table
print(table.to_numpy(), table["g"].max(), table.units["g"].upper(), table.plot().get_title())
figure: float = shells.figures["pressure"].value + float(mean)
merged = carom.replicas(scene, 4, until=1.0, measures=["pressure", {"kind": "correlation", "of": "gas"}])
total = merged + carom.run(scene)
study = carom.Study(scene, {"gas.0.count": [10, 20], ("gas.0.radius", "gas.0.mass"): [(0.01, 1.0)]}, replicas=2)
points: list[carom.Point] = study.run(executor=ThreadPoolExecutor(2), progress=True)
print(points[0].values["gas.0.count"], points[0].results.figures["bodies"].value, study.points, len(study.scenes))
found = carom.first_contact(carom.Molecule.disc(1.0), carom.Molecule.rod(3, radius=1.0), [1, 2], np.zeros((3, 2)))
print(found.time.sum(), found.atoms, sim.positions.mean(), total.runs[0][0], str(sim.show()))
new = sim.add(carom.Molecule([(0, 0, 1, 1)]), [0.5, 0.5], velocity=[1, 0], tags="x")
sim.remove(new)
square: carom.Molecule = carom.Molecule.square(0.1, rounding=1e-3)
needle = carom.Molecule([(0, 0, 0.1, 1), (1, 0, 0.1, 1)], edges=[(0, 1)], edge_radius=0.05, hollow=False)
lines: list[carom.ExposedSide] = carom.Molecule.polygon([[0, 0], [1, 0], [0, 1]]).exposed_sides(0.1)
print(square.edges[0, 1], needle.edge_shares().sum(), lines[0].length, carom.Molecule.kite(1, 0.5, size=1.0).area)
sim.set_energy(1.0, sim.positions[:, 0] > 0.5)
sim.thermostat("gas", "langevin", every=0.1, friction=1.0, temperature=2.0)
sim.set_transparent(["gas", ("gas", "x")])
carom.load("x").run(1)
carom.open_run("y")["x"]
read = carom.from_gsd("a.gsd", 0, radius={"A": 0.1}), carom.from_lammps("a.data", radius={1: 0.1}, mass=1.0)
print(read[0].replaced(seed=1), carom.from_dynamo("a.xml").tables)
view: carom.LiveView = carom.live(sim, size=320)
view.run(until=4.0, every=0.1, rate=30)
view.update()
