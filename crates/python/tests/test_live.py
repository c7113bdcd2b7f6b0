"""The live view of a simulation in a notebook, with a stand-in for the display of IPython."""

import sys
import types

import carom
import pytest

GAS = {"radius": 0.02, "mass": 1.0, "energy": 1.0, "count": 20}


class Display:
    """Keeps what is displayed: a list of lists, one for each place, of its pictures."""

    def __init__(self):
        self.places = []

    def __call__(self, data, *, raw, display_id):
        assert raw and display_id is True
        self.places.append([data])
        pictures = self.places[-1]

        def update(changed, *, raw):
            assert raw
            pictures.append(changed)

        return types.SimpleNamespace(update=update)


@pytest.fixture
def display(monkeypatch):
    """The display of a session of IPython that does not exist."""
    found = Display()
    shell, module = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    shell.get_ipython = object
    shell.display, module.display = module, found
    monkeypatch.setitem(sys.modules, "IPython", shell)
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    return found


@pytest.fixture
def sim():
    return carom.Simulation(carom.Scene(gas=GAS, seed=1))


def times(pictures):
    return [float(picture["text/plain"].split(" at time ")[1].split(",")[0]) for picture in pictures]


def test_the_picture_is_redrawn_in_one_place(display, sim):
    view = carom.live(sim, size=200)
    view.run(until=1.0, every=0.25, rate=1e6)
    [pictures] = display.places
    assert times(pictures) == [0.0, 0.25, 0.5, 0.75, 1.0] and sim.time == 1.0
    for picture in pictures:
        assert "<svg" in picture["text/html"] and picture["text/plain"].startswith("20 bodies at time ")
    assert len({picture["text/html"] for picture in pictures}) == 5
    sim.run(until=1.5)
    view.update()
    view.run(until=2.0, rate=1e6)
    assert times(pictures)[5:7] == [1.5, 1.5025] and len(pictures) == 6 + 200 and times(pictures)[-1] == 2.0
    # The end of a run is drawn also where `every` does not divide it.
    view.run(until=2.5, every=0.2, rate=1e6)
    assert times(pictures)[-3:] == [2.2, 2.4, 2.5] and len(display.places) == 1


def test_a_fast_run_waits_for_the_rate(display, sim, monkeypatch):
    clock = [100.0]
    monkeypatch.setattr("carom._live.time.monotonic", lambda: clock[0])
    monkeypatch.setattr("carom._live.time.sleep", lambda wait: clock.__setitem__(0, clock[0] + wait))
    carom.live(sim).run(until=1.0, every=0.1, rate=4)
    # Between the first and the ninth picture; the last one is drawn at once.
    assert clock[0] == pytest.approx(100.0 + 8 / 4)


def test_an_exception_leaves_the_time_at_which_it_came(display, sim):
    view = carom.live(sim)

    @sim.on_collision()
    def stop(hit):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        view.run(until=100.0, every=1.0, rate=1e6)
    [pictures] = display.places
    assert times(pictures)[-1] == pytest.approx(sim.time, rel=1e-5) and sim.time < 100.0
    sim.off_collision(stop)
    view.run(until=sim.time, rate=1e6)
    assert "1 collisions" in pictures[-1]["text/plain"]


def test_errors_name_the_argument(display, sim):
    view = carom.live(sim)
    sim.run(until=1.0)
    for arguments, error, words in [
        ({"until": 2.0, "every": 0.0}, ValueError, "`every` must be positive, but is 0"),
        ({"until": 2.0, "every": -1}, ValueError, "`every` must be positive, but is -1"),
        ({"until": 2.0, "rate": 0}, ValueError, "`rate` must be positive, but is 0"),
        ({"until": 2.0, "every": 1e-9}, ValueError, "`every`: there would be 1e.09 pictures; at most 1e6"),
        ({"until": "2"}, TypeError, "`until` must be a number"),
        ({"until": 0.5}, carom.RunError, "."),
        ({"until": float("nan")}, carom.RunError, "."),
    ]:
        with pytest.raises(error, match=words):
            view.run(**arguments)
    assert sim.time == 1.0
    with pytest.raises(TypeError, match="a simulation is expected, not"):
        carom.live(sim.scene)
    with pytest.raises(ValueError, match="`size` must be a whole number from 16 to 16384"):
        carom.live(sim, size=1)


def test_without_a_session_nothing_is_drawn(display, sim, monkeypatch):
    monkeypatch.setattr(sys.modules["IPython"], "get_ipython", lambda: None)
    view = carom.live(sim)
    view.run(until=0.5, every=0.1, rate=1e6)
    assert not display.places and repr(view) == "<carom.LiveView of 20 bodies at time 0.5>"


def test_without_ipython_the_error_says_how_to_install_it(sim, monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython", None)
    with pytest.raises(ImportError, match="this needs the package ipython: pip install ipython"):
        carom.live(sim)


def test_ipython_itself_displays_and_updates(sim, monkeypatch):
    shell = pytest.importorskip("IPython.core.interactiveshell").InteractiveShell.instance()
    try:
        sent = []
        monkeypatch.setattr(shell.display_pub, "publish", lambda data, *_, **more: sent.append((data, more)))
        view = carom.live(sim)
        view.run(until=0.5, every=0.25, rate=1e6)
    finally:
        type(shell).clear_instance()
    assert ["<svg" in data["text/html"] for data, _ in sent] == [True] * 3
    assert [bool(more.get("update")) for _, more in sent] == [False, True, True]
    assert len({more["transient"]["display_id"] for _, more in sent}) == 1
