"""The test of the conda package: a first gas, whose pressure is that of hard discs."""

import carom

gas = {"radius": 0.02, "mass": 1, "temperature": 1, "velocities": "maxwell", "count": 200, "tags": ["gas"]}
scene = carom.Scene(gas=gas, run={"until": 20, "sample_interval": 0.1, "measure_from": 2}, seed=1)
pressure = carom.run(scene, measures=["pressure"]).figures["pressure"]
print(carom.__version__, pressure)
assert pressure.standard_error is not None and pressure.prediction is not None
assert abs(pressure.value - pressure.prediction) < 5 * pressure.standard_error
