"""Creatures move, each with its own body, and leave as robots."""

import mujoco
import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import ExperimentError
from gaitsim.experiment import load_experiment
from gaitsim.plugin import Subject
from gaitsim.plugin.pictures import PLOT_THEMES
from gaitsim.plugin.runs import Individual
from gaitsim_creatures.assembly import Parts, assembly_figure
from gaitsim_creatures.organism import NO_HINGES, Creature
from gaitsim_creatures.trees import HEAD
from gaitsim_robot.organism import CHANNELS

SHORT = {"duration": 1.0}


def population(creature: Creature, count: int = 12, seed: int = 2) -> np.ndarray:
    """Return random genomes of creatures."""
    return creature.genome_space().random(count, np.random.default_rng(seed))


def test_each_individual_moves_exactly_as_with_its_own_body() -> None:
    """Padding and company change no bits, and what is padded is 0."""
    creature = Creature(**SHORT)
    genomes = population(creature)
    motion = creature.move(genomes)
    joints = motion["present"].sum(axis=1)
    assert len({*joints}) > 3
    for row, genome in enumerate(genomes):
        if row in motion.failures:
            continue
        body, genes = creature.embody(genome)
        own = body.move(genes[None])
        assert len(body.joint_names()) == joints[row]
        for name in own:
            axes, values = body.channels[name].axes, own[name][0]
            inside = tuple(slice(length) for length in values.shape)
            np.testing.assert_array_equal(motion[name][row][inside], values, name)
            if "joints" in axes and name in CHANNELS:
                assert not motion[name][row][..., joints[row] :].any()
    alone = np.concatenate([creature.move(genome[None])["torso"] for genome in genomes])
    np.testing.assert_array_equal(motion["torso"], alone)


def test_scores_do_not_depend_on_padding() -> None:
    """A body with room for more joints scores the same, to the bit."""
    few, many = (
        load_experiment("creature", {"organism.most": most, "organism.duration": 1.0})
        for most in (8, 30)
    )
    genomes = population(few.organism, 6)
    wide = np.zeros((6, many.space().genes))
    wide[:, : genomes.shape[1]] = genomes
    weights = {"torque_share": 0.0, "rough_weight": 1.0}
    fitness = few.fitness.model_copy(update=weights)
    for name, term in fitness.terms(few.organism.move(genomes)).items():
        np.testing.assert_array_equal(term, fitness.terms(many.organism.move(wide))[name], name)


def test_a_core_without_hinges_fails_with_a_reason() -> None:
    """It lies still; the others of its population move."""
    creature = Creature(**SHORT)
    genomes = population(creature, 3)
    genomes[1, HEAD:] = 0.0
    motion = creature.move(genomes)
    assert motion.failures == {1: NO_HINGES}
    assert np.ptp(motion["torso"][1], axis=0).max() == 0
    assert creature.embody(genomes[1])[0] is creature


def test_no_energy_comes_from_nothing() -> None:
    """The work of the servos exceeds the gain of potential and kinetic energy."""
    creature = Creature(duration=3.0)
    genomes = population(creature, 20, seed=5)
    motion, bodies = creature.move(genomes), creature._tree_space.grow(genomes)
    for row in set(range(20)) - {*motion.failures}:
        simulation = creature._simulation(bodies, row)
        model, joints = simulation.model, len(simulation.ctrl)
        data, energies = mujoco.MjData(model), []
        for frame in (0, -1):
            data.qpos[:] = motion["configuration"][row, frame, : 7 + joints]
            data.qvel[:3] = motion["torso_velocity"][row, frame]
            data.qvel[6:] = motion["joint_velocities"][row, frame, :joints]
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_energyPos(model, data)
            energies.append(
                data.energy[0] + 0.5 * simulation.anatomy.mass * (data.qvel[:3] ** 2).sum()
            )
        assert energies[1] - energies[0] <= motion["energy"][row, -1] + 1e-3


def test_hinges_obey_their_oscillators_and_the_speed_of_their_servos() -> None:
    """Commands are sines within the reach, no faster than the servo turns."""
    creature = Creature(body="gecko", fastest=5.0)
    space = creature.genome_space()
    motion = creature.move(space.repair(np.full((1, space.genes), 9.0)))
    angles = motion["joint_angles"][0]
    speed = np.abs(np.diff(angles[100:], axis=0)).max() * 50
    servo = creature._servo
    assert speed <= servo.no_load_speed
    assert np.abs(angles).max() <= np.radians(60) + 1e-12


def test_worlds_and_checks_change_the_motion() -> None:
    """Friction, servos and uneven ground act on creatures as on robots."""
    creature = Creature(**SHORT)
    genomes = population(creature, 4)
    plain = creature.move(genomes)["torso"]
    for world in ({"friction": 0.2}, {"servo_stiffness": 0.5}, {"rubble": 0.05, "seed": 1}):
        assert (creature.model_copy(update={"world": world}).move(genomes)["torso"] != plain).any()
    experiment = load_experiment("creature-rough")
    assert experiment.worlds.number == 3


def test_a_creature_leaves_as_mjcf_and_urdf_with_its_masses(tmp_path) -> None:
    """Both files compile, with the names of the hinges, and the same mass."""
    body = Creature(body="spider")
    mass = body.simulation.model.body_mass.sum()
    model = mujoco.MjModel.from_xml_string(body.mjcf())
    assert [model.joint(index).name for index in range(1, model.njnt)] == [*body.joint_names()]
    assert model.body_mass.sum() == pytest.approx(mass, rel=1e-6)
    assert model.jnt_actfrcrange[1:, 1] == pytest.approx(0.948)
    path = tmp_path / "spider.urdf"
    path.write_text(body.urdf())
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = False
    read = spec.compile()
    assert {read.joint(index).name for index in range(read.njnt)} == {*body.joint_names()}
    assert read.body_mass.sum() == pytest.approx(mass, rel=1e-5)


def test_searches_that_need_real_genes_name_those_that_do_not() -> None:
    """CMA-ES cannot search trees; a body with a plan has real genes."""
    with pytest.raises(ExperimentError) as found:
        load_experiment("creature", {"search.plugin": "cma-es"})
    assert "genetic" in str(found.value)
    assert "age-fitness" in str(found.value)
    with pytest.raises(ExperimentError, match="use 'operators'"):
        load_experiment("creature-zoo", {"search.variation": "line"})
    with pytest.raises(ExperimentError) as found:
        load_experiment("creature", {"mutation.plugin": "gaussian"})
    assert "tree" in str(found.value)
    assert load_experiment("gecko").space().name == "real"


def test_a_run_keeps_each_individuals_own_body(tmp_path) -> None:
    """Its best individual is measured, drawn and replayed with its own joints."""
    quick = {"organism.duration": 1.0, "evolution.population": 8, "evolution.generations": 2}
    for _ in gs.evolve("creature", out=tmp_path / "run", set=quick):
        pass
    best = gs.load(tmp_path / "run").champion
    assert best.replayed_score == pytest.approx(best.score, rel=0, abs=0)
    joints = best.body.joint_names()
    assert best.joint_angles.shape[1] == len(joints)
    assert len(best.skeleton.contact_names) == len(joints) + 1
    assert best.measures["hinges"] == len(joints)
    assert len(best.skeleton.solids) == 1 + int(best.measures["modules"]) + len(joints)


def test_a_creature_can_be_built_from_its_drawing_and_its_parts(tmp_path) -> None:
    """The drawing names each module, and the list of parts has its mass and its face."""
    experiment = load_experiment("gecko", {"organism.body": "L hinge 90, LF brick"})
    genome = experiment.space().random(1, np.random.default_rng(0))[0]
    individual = Individual(experiment, 0.0, {}, genome=genome)
    figure = assembly_figure(individual, PLOT_THEMES["dark"])
    figure.savefig(tmp_path / "assembly.png")
    written = {text.get_text() for axes in figure.axes for text in axes.texts}
    assert {"core", "L", "LF"} <= written
    Parts().write(Subject(None, (individual,)), tmp_path / "parts.csv")
    rows = (tmp_path / "parts.csv").read_text().splitlines()
    assert rows[1:] == [
        "core,core,,,0,0.25",
        "L,hinge,core,left,90,0.089",
        "LF,brick,L,front,0,0.03",
    ]
    spider = load_experiment("spider")
    other = Individual(
        spider, 0.0, {}, genome=spider.space().random(1, np.random.default_rng(0))[0]
    )
    with pytest.raises(gs.GaitsimError, match="not a creature"):
        Parts().check(other)
