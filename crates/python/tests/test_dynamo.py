"""Scenes from configurations of DynamO, written by hand in its documented format."""

import bz2

import carom
import numpy as np
import pytest

PAIR_AB = (
    '<IDPairRange Type="Pair"><IDRange Type="Ranged" Start="0" End="1"/>'
    '<IDRange Type="List"><ID val="2"/><ID val="3"/></IDRange></IDPairRange>'
)
FILE = f"""<?xml version="1.0"?>
<DynamOconfig version="1.5.0">
  <Simulation lastMFT="1.0">
    <Scheduler Type="NeighbourList"><Sorter Type="BoundedPQMinMax3"/></Scheduler>
    <SimulationSize x="10" y="8" z="12"/>
    <Genus>
      <Species Mass="1" Name="A" IntName="AA" Type="Point"><IDRange Type="Ranged" Start="0" End="1"/></Species>
      <Species Mass="4" Name="B" IntName="BB" Type="Point"><IDRange Type="Ranged" Start="2" End="3"/></Species>
    </Genus>
    <BC Type="PBC"/>
    <Topology/>
    <Interactions>
      <Interaction Type="SquareWell" Diameter="1" Elasticity="1" Lambda="1.5" WellDepth="2" Name="AA">
        <IDPairRange Type="Single"><IDRange Type="Ranged" Start="0" End="1"/></IDPairRange>
        <CaptureMap/>
      </Interaction>
      <Interaction Type="HardSphere" Diameter="1.2" Elasticity="0.9" Name="AB">{PAIR_AB}</Interaction>
      <Interaction Type="HardSphere" Diameter="2" Name="BB"><IDPairRange Type="All"/></Interaction>
    </Interactions>
    <Locals/>
    <Globals><Global Type="Cells" Name="SchedulerNBList" NeighbourhoodRange="1.5"/></Globals>
    <SystemEvents/>
    <Dynamics Type="Newtonian"/>
  </Simulation>
  <Properties/>
  <ParticleData>
    <Pt ID="0"><P x="-4" y="-3" z="2"/><V x="1" y="0.5" z="0"/></Pt>
    <Pt ID="1"><P x="-2" y="-3" z="2"/><V x="-1" y="0" z="0"/></Pt>
    <Pt ID="2"><P x="2" y="0" z="2"/><V x="0" y="0" z="0"/></Pt>
    <Pt ID="3"><P x="2" y="3" z="2"/><V x="0.25" y="-1" z="-0.0"/></Pt>
  </ParticleData>
</DynamOconfig>
"""


@pytest.fixture
def scene_of(tmp_path):
    """A function that reads the file with replaced pieces."""

    def read(*changes):
        text = FILE
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        (tmp_path / "config.xml").write_text(text)
        return carom.from_dynamo(tmp_path / "config.xml")

    return read


def column(scene, key):
    return [one.get(key) for one in scene.tables["molecule"]]


def test_particles_have_places_velocities_masses_and_species(scene_of):
    scene = scene_of()
    assert scene.tables["box"]["sides"] == [10.0, 8.0]
    assert column(scene, "at") == [[1.0, 1.0], [3.0, 1.0], [7.0, 4.0], [7.0, 7.0]]
    assert column(scene, "velocity") == [[1.0, 0.5], [-1.0, 0.0], [0.0, 0.0], [0.25, -1.0]]
    assert column(scene, "atom_radius") == [0.5, 0.5, 1.0, 1.0] and column(scene, "atom_mass") == [1.0, 1.0, 4.0, 4.0]
    assert column(scene, "tags") == [["A"], ["A"], ["B"], ["B"]]


def test_interactions_become_rules_of_pairs(scene_of):
    tables = scene_of().tables
    [diameter], [well], [pair] = tables["diameter"], tables["well"], tables["elasticity"]["pair"]
    assert diameter["between"] == ["A", "B"] and diameter["factor"] == pytest.approx(0.8, rel=1e-15)
    assert well["between"] == ["A"] and well["steps"] == [[1.5, -2.0]]
    assert sorted(pair["between"]) == ["A", "B"] and pair["coefficient"] == 0.9
    assert tables["elasticity"]["default"] == 1.0 and not tables.get("transparent")


def test_the_motion_is_that_of_the_potential(scene_of):
    # Two discs meet head on: u² = u₀² + 2 depth / μ within the well, with the relative speed u and μ = 1/2.
    apart = ('<V x="1" y="0.5" z="0"/>', '<V x="1" y="0" z="0"/>')
    alone = ('<V x="0.25" y="-1" z="-0.0"/>', '<V x="0" y="0" z="0"/>')
    sim = carom.Simulation(scene_of(apart, alone).replaced(seed=1))
    steps = sim.collisions(until=0.5)
    assert steps["time"][0] == pytest.approx(0.25, rel=1e-12)
    after = steps["velocities_after"][0]
    assert np.abs(after[0] - after[1])[0] == pytest.approx(np.sqrt(2.0**2 + 2 * 2 / 0.5), rel=1e-12)
    assert sim.overlapping_pairs == 0 and len(sim) == 4


def test_a_compressed_file_is_the_same(scene_of, tmp_path):
    scene = scene_of()
    (tmp_path / "config.xml.bz2").write_bytes(bz2.compress(FILE.encode()))
    assert carom.from_dynamo(str(tmp_path / "config.xml.bz2")) == scene


def test_the_first_interaction_of_a_pair_decides(scene_of):
    everything = '<Interaction Type="HardSphere" Diameter="0.5" Name="all"><IDPairRange Type="All"/></Interaction>'
    tables = scene_of(("<Interactions>", f"<Interactions>{everything}")).tables
    assert {one["atom_radius"] for one in tables["molecule"]} == {0.25}
    assert not any(tables.get(key) for key in ("well", "diameter", "transparent"))
    # An interaction of particles with themselves draws them, and has no events.
    alone = everything.replace('<IDPairRange Type="All"/>', '<IDPairRange Type="Self"><IDRange Type="All"/></IDPairRange>')
    assert scene_of(("<Interactions>", f"<Interactions>{alone}")) == scene_of()


def test_pairs_without_interaction_do_not_see_each_other(scene_of):
    null = '<Interaction Type="Null" Name="BB">'
    tables = scene_of(('<Interaction Type="HardSphere" Diameter="2" Name="BB">', null)).tables
    assert [one["between"] for one in tables["transparent"]] == [["B"]]
    # The radius of B is what A leaves of the diameter of both.
    assert [one["atom_radius"] for one in tables["molecule"]] == pytest.approx([0.5, 0.5, 0.7, 0.7])
    assert not tables.get("diameter")


def test_an_interaction_may_divide_a_species(scene_of):
    first = (
        '<Interaction Type="HardSphere" Diameter="1.5" Name="one"><IDPairRange Type="Union"><IDPairRange Type="None"/>'
        '<IDPairRange Type="Pair"><IDRange Type="Union"><IDRange Type="None"/><IDRange Type="List"><ID val="3"/></IDRange>'
        '</IDRange><IDRange Type="All"/></IDPairRange></IDPairRange></Interaction>'
    )
    tables = scene_of(("<Interactions>", f"<Interactions>{first}")).tables
    assert [one["tags"] for one in tables["molecule"]] == [["A"], ["A"], ["B", "B-1"], ["B", "B-2"]]
    assert [one["atom_radius"] for one in tables["molecule"]] == [0.5, 0.5, 1.0, 0.75]
    factors = {tuple(one["between"]): one["factor"] for one in tables["diameter"]}
    assert factors == pytest.approx({("A", "B-1"): 0.8, ("A", "B-2"): 1.2, ("B-1", "B-2"): 1.5 / 1.75})


def test_rules_for_each_pair_of_particles_are_refused(scene_of):
    pair = '<Interaction Type="Null" Name="{0}"><IDPairRange Type="Single"><IDRange Type="List"><ID val="{0}"/></IDRange>'
    singles = "".join(f"{pair.format(index)}</IDPairRange></Interaction>" for index in range(100))
    particle = '<Pt><P x="0" y="0" z="2"/><V x="0" y="0" z="0"/></Pt>'
    with pytest.raises(carom.SceneError, match="divide the particles into 100 groups; at most 64 are read"):
        scene_of(("<Interactions>", f"<Interactions>{singles}"), ("</ParticleData>", f"{particle * 96}</ParticleData>"),
                 ('Start="2" End="3"/></Species>', 'Start="2" End="99"/></Species>'))


def test_properties_are_numbers_of_each_particle(scene_of):
    changes = [
        ("<Properties/>", '<Properties><Property Type="PerParticle" Name="D" Units="Length"/>'
         '<Property Type="PerParticle" Name="M" Units="Mass"/></Properties>'),
        ('<Interaction Type="HardSphere" Diameter="2" Name="BB">', '<Interaction Type="HardSphere" Diameter="D" Name="BB">'),
        ('Mass="4"', 'Mass="M"'), ('<Pt ID="2">', '<Pt ID="2" D="1.5" M="2.5">'), ('<Pt ID="3">', '<Pt ID="3" D="1" M="3.5">'),
    ]
    first = ('<Interaction Type="SquareWell" Diameter="1"', '<Interaction Type="SquareWell" Diameter="D"')
    all_alike = [first, ('Diameter="1.2"', 'Diameter="D"'), ('<Pt ID="0">', '<Pt ID="0" D="1">'),
                 ('<Pt ID="1">', '<Pt ID="1" D="0.5">')]
    scene = scene_of(*changes, *all_alike)
    assert column(scene, "atom_radius") == [0.5, 0.25, 0.75, 0.5] and column(scene, "atom_mass") == [1.0, 1.0, 2.5, 3.5]
    assert not scene.tables.get("diameter")
    with pytest.raises(carom.SceneError, match="interaction 'AB': particles of the species 'A' and 'B' have diameters of"):
        scene_of(*changes)
    with pytest.raises(carom.SceneError, match="particle 0: Pt has no D"):
        scene_of(*changes, *all_alike[:2])


def test_a_fixed_collider_is_fixed(scene_of):
    scene = scene_of(('Mass="4" Name="B" IntName="BB" Type="Point"', 'Name="B" Type="FixedCollider"'),
                     ('<V x="0.25" y="-1" z="-0.0"/>', '<V x="0" y="0" z="0"/>'))
    assert [bool(fixed) for fixed in column(scene, "fixed")] == [False, False, True, True]
    sim = carom.Simulation(scene)
    sim.run(until=20.0)
    assert sim.positions[2:].tolist() == [[7.0, 4.0], [7.0, 7.0]] and sim.collision_count > 0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('<?xml version="1.0"?>', "hello", "cannot be read as XML"),
        ("DynamOconfig", "config", "it is no configuration of DynamO: its first element is 'config'"),
        ('version="1.5.0"', 'version="1.4.0"', "version 1.5.0 is read, but the file has '1.4.0'; a newer dynamod"),
        ('<BC Type="PBC"/>', "", "Simulation has no BC"),
        ('<BC Type="PBC"/>', '<BC Type="LE" DXD="0" Rate="1"/>', "BC of type 'LE' is not read, 'PBC' is"),
        ('Dynamics Type="Newtonian"', 'Dynamics Type="NewtonianGravity"', "Dynamics of type 'NewtonianGravity' is not"),
        ("<Locals/>", '<Locals><Local Type="Wall" Name="w"/></Locals>', "Locals: Local of type 'Wall' is not read"),
        ('Type="Cells"', 'Type="SOCells"', "Globals: Global of type 'SOCells' is not read"),
        ("<SystemEvents/>", '<SystemEvents><System Type="Andersen" MFT="1"/></SystemEvents>', "type 'Andersen' is not"),
        ('x="10" y="8"', 'x="10" y="-8"', "SimulationSize: y must be positive, but is -8"),
        ('x="10" y="8"', 'x="10" y="8m"', "SimulationSize: y must be a number, but is '8m'"),
        ('x="2" y="0" z="2"', 'x="2" y="0" z="2.5"', r"particle 2: z is 2.5 and its velocity 0, but must be 2, that of"),
        ('y="0.5" z="0"', 'y="0.5" z="0.1"', "particle 0: z is 2 and its velocity 0.1, but must be 2"),
        ('<V x="1" y="0.5" z="0"/>', "", "particle 0: it has no V"),
        ('y="0.5" z="0"', 'y="nan" z="0"', "particle 0: V is not finite"),
        ('<Pt ID="3">', '<Pt ID="3" Static="Static">', "particle 3: static particles are not read"),
        ('Mass="4"', 'Mass="-4"', "particle 2: the mass must be positive, but is -4"),
        ('Mass="4"', 'Mass="M"', "species 'B': Mass must be a number, but is 'M'"),
        ('Diameter="2"', 'Diameter="0"', "interaction 'BB': Diameter must be positive, but is 0"),
        ('Name="B" IntName="BB" Type="Point"', 'Name="A" Type="Point"', "two species have one name: A, A"),
        ('Name="B" IntName="BB" Type="Point"', 'Name="B" Type="Lines"', "species 'B': the type 'Lines' is not read; Point"),
        ('Start="2" End="3"', 'Start="1" End="3"', "particle 1 must have one species, but has 2"),
        ('Start="2" End="3"', 'Start="2" End="x"', "species 'B': End must be the number of a particle .* but is 'x'"),
        ('<ID val="2"/>', '<ID val="-2"/>', "interaction 'AB': val must be the number of a particle .* but is '-2'"),
        ('IDPairRange Type="All"', 'IDPairRange Type="Chains"', "'BB': IDPairRange of type 'Chains' is not read; All"),
        ('IDPairRange Type="All"', 'IDPairRange Type="Self"', "'BB': IDPairRange of type Self must have 1 IDRange, but"),
        ('IDPairRange Type="All"', 'IDPairRange Type="None"', "the particles 3 and 3|the particles 2 and 3 have no"),
        ('Type="HardSphere" Diameter="2"', 'Type="Lines" Length="2"', "'BB': the type 'Lines' is not read; HardSphere"),
        ('Lambda="1.5"', 'Lambda="1"', "interaction 'AA': Lambda must be above 1, but is 1"),
        ('WellDepth="2"', "", "interaction 'AA': Interaction has no WellDepth"),
        (' Name="BB"', ' TangentialElasticity="0.5" Name="BB"', "TangentialElasticity is 0.5, but must be 1"),
    ],
)
def test_what_carom_cannot_read_is_refused_by_name(scene_of, old, new, words):
    with pytest.raises(carom.SceneError, match=words):
        scene_of((old, new))


def test_a_file_that_is_missing_or_damaged_is_refused(tmp_path):
    with pytest.raises(carom.SceneError, match="no-such-file.*No such file"):
        carom.from_dynamo(tmp_path / "no-such-file")
    (tmp_path / "cut.bz2").write_bytes(bz2.compress(FILE.encode())[:100])
    with pytest.raises(carom.SceneError, match="cannot be read as XML"):
        carom.from_dynamo(tmp_path / "cut.bz2")
