"""Speeds of the package: python crates/python/bench/speed.py COMMAND

COMMAND is the command `carom`. Both run the same scene in turn; times are
processor times. With the package `billiards` installed, a small closed gas is run by both.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import carom

ROUNDS = 11


def alternated(command):
    run = {"until": 20.0, "sample_interval": 20.0, "animation": False}
    scene = carom.Scene(gas={"radius": 0.01, "mass": 1, "energy": 1, "count": 1592}, run=run, seed=1)
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "gas.toml").write_text(scene.to_toml())
    ratios = []
    for _ in range(ROUNDS):
        words = [command, "run", str(folder / "gas.toml"), "--out", str(folder / "out"), "--force"]
        subprocess.run(words, check=True, capture_output=True)
        summary = json.loads((folder / "out" / "summary.json").read_text())
        sim = carom.Simulation(scene)
        begun = time.thread_time()
        sim.run(until=20.0)
        speed = sim.collision_count / (time.thread_time() - begun)
        assert sim.collision_count == summary["collisions"]
        ratios.append(speed / summary["collisions_per_second"])
        print(f"{speed / 1e6:.2f} million collisions a second, {ratios[-1]:.3f} of the command")
    print(f"median ratio {statistics.median(ratios):.3f}, from {min(ratios):.3f} to {max(ratios):.3f}")
    begun, before = time.thread_time(), len(sim.collisions(until=20.0))
    rows = sim.collisions(until=23.0)
    print(f"{(len(rows) - before) / (time.thread_time() - begun) / 1e6:.2f} million rows a second")


def arrays():
    sim = carom.Simulation(carom.Scene(gas={"radius": 3e-4, "mass": 1, "energy": 1, "count": 1_000_000}))
    times = []
    for _ in range(ROUNDS):
        begun = time.thread_time()
        sim.positions
        times.append(time.thread_time() - begun)
    print(f"positions of 10^6 bodies: {1e3 * statistics.median(times):.1f} ms")


def closed_gas():
    try:
        import billiards
    except ImportError:
        print("the package billiards is not installed")
        return
    gas = {"radius": 0.02, "mass": 1, "energy": 1, "count": 100, "tags": ["gas"]}
    sim = carom.Simulation(carom.Scene(wall=[{"x": 0.0}, {"y": 0.0}], gas=gas, seed=1))
    walls = [((0, 0), (0, 1), "right"), ((1, 0), (1, 1), "left"), ((0, 0), (1, 0), "left"), ((0, 1), (1, 1), "right")]
    other = billiards.Billiard([billiards.InfiniteWall(*wall) for wall in walls])
    for body in sim.mask("gas").nonzero()[0]:
        other.add_ball(sim.positions[body], sim.velocities[body], radius=0.02, mass=1.0)
    begun = time.process_time()
    count = len(other.evolve(2.0))
    theirs = (time.process_time() - begun) / count
    begun = time.process_time()
    sim.run(until=200.0)
    ours = (time.process_time() - begun) / sim.collision_count
    print(f"100 discs in a closed box: billiards {1e6 * theirs:.0f}, carom {1e6 * ours:.2f} µs a collision, "
          f"ratio {theirs / ours:.0f}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    alternated(sys.argv[1])
    arrays()
    closed_gas()
