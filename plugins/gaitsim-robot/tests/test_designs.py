"""Robots with other dimensions: lengths, masses and poses against closed forms and MuJoCo."""

import mujoco
import numpy as np
import pytest
from mechanisms import mechanism, parallelogram
from small_robots import HEXAPOD, QUADRUPED, biped

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim_robot.chain import pose_data
from gaitsim_robot.designs import MASS_PER_TORQUE
from gaitsim_robot.linkage import standing_chains
from gaitsim_robot.organism import Robot

DIMENSIONS = {
    "quadruped": ("thigh", "shank", "hips.width", "trunk"),
    "hexapod": ("femur", "servos"),
}


def chain_of(robot, leg=0):
    return standing_chains(robot.simulation.model, robot.anatomy)[leg]


def evolving(name, dimensions, count, seed=0, **options):
    """Return a robot with evolving dimensions, and genomes of one gait with random dimensions."""
    robot = Robot(model=name, evolve=dimensions, duration=1.0, **options)
    genomes = np.tile(next(iter(robot.starts().values())), (count, 1))
    factors = np.random.default_rng(seed).uniform(0.8, 1.2, (count, len(dimensions)))
    genomes[:, -len(dimensions) :] = factors
    return robot, genomes


def load_file(tmp_path, text, **options):
    """Return the robot in a file."""
    path = tmp_path / "robot.xml"
    path.write_text(text)
    overrides = {f"organism.{name}": value for name, value in options.items()}
    return load_experiment(str(path), overrides).organism


def test_segments_have_their_lengths_and_names():
    lengths = {name: one.nominal for name, one in Robot(model="quadruped").design_space().items()}
    assert lengths["hip"] == pytest.approx(0.045)
    assert lengths["thigh"] == lengths["row2.thigh"] == lengths["R1.thigh"] == pytest.approx(0.11)
    assert lengths["hips.length"] == pytest.approx(0.24)
    assert lengths["hips.width"] == pytest.approx(0.08)
    assert {"coxa", "femur", "tibia"} <= {*Robot(model="hexapod").design_space()}


def test_a_biped_has_thighs_shanks_and_feet(tmp_path):
    robot = load_file(tmp_path, biped(0.01))
    lengths = {name: one.nominal for name, one in robot.design_space().items() if "." not in name}
    assert lengths["thigh"] == lengths["shank"] == pytest.approx(0.4)
    assert lengths["foot"] == pytest.approx(0.05)


@pytest.mark.parametrize("factor", [0.7, 1.25])
def test_a_stretched_segment_has_its_length_and_the_foot_stays_on_the_ground(factor):
    original = Robot(model="quadruped")
    robot = Robot(model="quadruped", dimensions={"shank": factor})
    before, after = chain_of(original), chain_of(robot)
    apart = [np.linalg.norm(one.anchors[2] - one.anchors[1]) for one in (before, after)]
    assert apart[0] == pytest.approx(apart[1])
    ball = [np.linalg.norm(one.tip - one.anchors[2]) for one in (before, after)]
    assert ball[1] - ball[0] == pytest.approx((factor - 1) * 0.11, abs=2e-3)
    data = pose_data(robot.simulation.model, robot.anatomy.stance)
    feet = [data.site_xpos[data.site(f"world: foot {leg.name}").id] for leg in robot.anatomy.legs]
    assert np.abs(np.array(feet)[:, 2]).max() < 2e-3
    # The feet stay in place relative to the centre of mass.
    offsets = []
    for one in (original, robot):
        data = pose_data(one.simulation.model, one.anatomy.stance)
        tips = [chain_of(one, leg).tip[:2] for leg in range(4)]
        offsets.append(data.subtree_com[1][:2] - np.mean(tips, axis=0))
    assert offsets[0] == pytest.approx(offsets[1], abs=1e-3)


def test_without_a_part_that_stays_a_box_grows_like_a_box():
    before = Robot(model="quadruped").simulation.model
    after = Robot(model="quadruped", dimensions={"trunk": 1.2}, growth=1.0).simulation.model
    trunk, mass = after.body("trunk"), 1.2 * before.body("trunk").mass[0]
    assert trunk.mass[0] == pytest.approx(mass)
    assert after.geom("trunk").size == pytest.approx([1.2 * 0.14, 0.05, 0.03])
    # The inertia of the file is rounded to three digits.
    length, width, height = 1.2 * 0.28, 0.1, 0.06
    squares = [width**2 + height**2, length**2 + height**2, length**2 + width**2]
    assert np.sort(trunk.inertia) == pytest.approx(np.sort(mass * np.array(squares) / 12), rel=3e-3)


def test_half_of_the_mass_of_a_link_grows_by_default():
    before, after = (
        Robot(model="quadruped", dimensions=factors).simulation.model
        for factors in ({}, {"shank": 1.3})
    )
    shank = before.body("L1 shank").mass[0]
    assert after.body("L1 shank").mass[0] == pytest.approx(1.15 * shank)
    assert after.body("L1 thigh").mass[0] == before.body("L1 thigh").mass[0]
    moved = after.body("L1 shank").ipos[2] / before.body("L1 shank").ipos[2]
    assert moved == pytest.approx(1.3)


def test_larger_servos_are_stronger_and_heavier():
    before, after = (Robot(model="quadruped", dimensions=one) for one in ({}, {"servos": 1.5}))
    assert after.simulation.stall_torque == pytest.approx(1.5 * before.simulation.stall_torque)
    added = after.anatomy.mass - before.anatomy.mass
    assert added == pytest.approx(12 * 0.5 * 1.9 * MASS_PER_TORQUE)
    named = Robot(model="quadruped", dimensions={"servos": 1.5}, servo="sts3215")
    assert named.anatomy.mass - before.anatomy.mass == pytest.approx(12 * 0.5 * 0.055)


def test_a_mesh_of_several_links_is_stretched_in_each_of_them(tmp_path):
    corners = " ".join(
        f"{x} {y} {z}" for x in (-0.01, 0.01) for y in (-0.01, 0.01) for z in (-0.18, 0)
    )
    text = QUADRUPED.replace(
        '<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.015" mass="0.2"/>',
        '<geom type="mesh" mesh="bar" mass="0.2"/>',
    ).replace("<worldbody>", f'<asset><mesh name="bar" vertex="{corners}"/></asset><worldbody>')
    before = load_file(tmp_path, text)
    model = before.model_copy(update={"dimensions": {"row1.thigh": 1.5}}).simulation.model
    heights = {}
    for leg in ("FL", "RL"):
        body = model.body(f"{leg}_thigh").id
        mesh = model.geom_dataid[np.flatnonzero(model.geom_bodyid == body)[0]]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        heights[leg] = np.ptp(model.mesh_vert[first : first + count], axis=0).max()
    assert heights == pytest.approx({"FL": 0.27, "RL": 0.18}, abs=1e-6)


@pytest.mark.parametrize("name", DIMENSIONS)
def test_an_individual_moves_as_in_its_population_bit_for_bit(name):
    robot, genomes = evolving(name, DIMENSIONS[name], 5)
    together = robot.move(genomes)
    assert not together.failures
    for index in (0, 4):
        body, genes = robot.embody(genomes[index])
        alone = body.move(genes[None])
        part = robot.move(genomes[index : index + 2])
        for channel in alone:
            assert np.array_equal(alone[channel][0], together[channel][index])
            assert np.array_equal(part[channel][0], together[channel][index])
        drawn = robot.skeleton(together, index).segments
        assert np.array_equal(drawn, body.skeleton(alone, 0).segments)


def test_individuals_with_reflexes_and_a_drive_move_as_alone():
    drive = ({"at": 0.0, "speed": 0.2},)
    reflexes = {"heading": {}, "level": {}}
    names = ("shank", "heading.gain")
    robot = Robot(model="quadruped", evolve=names, duration=1.0, reflexes=reflexes, drive=drive)
    genomes = np.tile(next(iter(robot.starts().values())), (4, 1))
    genomes[:, -1] = [0.8, 0.9, 1.1, 1.2]
    genomes[:, -2] = [0.1, 0.4, 0.7, 1.0]
    together = robot.move(genomes)
    body, genes = robot.embody(genomes[2])
    alone = body.move(genes[None])
    assert np.array_equal(alone["configuration"][0], together["configuration"][2])
    blind, plain = robot.blind(genomes)
    assert blind.genome_space().genes == plain.shape[1]
    assert plain[:, -1] == pytest.approx(genomes[:, -1])


def test_genes_of_steps_are_in_leg_lengths():
    short, long = (Robot(model="quadruped", dimensions={"shank": one}) for one in (0.8, 1.2))
    assert short.genome_space().upper == pytest.approx(long.genome_space().upper)
    genome = next(iter(short.starts().values()))
    strides = [
        np.ptp(robot._encoding.rhythm(genome[None]).stroke[0, 0, 0] * np.array([0, 1]))
        / robot.anatomy.legs[0].length
        for robot in (short, long)
    ]
    assert strides[0] == pytest.approx(strides[1])


def test_the_exported_file_plays_the_same_motion(tmp_path):
    robot, genomes = evolving("quadruped", DIMENSIONS["quadruped"], 1, servo="sts3215")
    body, genes = robot.embody(genomes[0])
    motion = body.move(genes[None])
    late = body.simulation.latency
    again = load_file(tmp_path, body.mjcf(), latency=late, duration=1.0, symmetry="none")
    played = again.play(motion["joint_angles"])
    assert np.abs(played["torso"] - motion["torso"]).max() < 1e-9


def test_a_design_that_collides_fails_with_the_reason():
    names = ("trunk", "hips.length")
    robot, genomes = evolving("quadruped", names, 2, ranges=dict.fromkeys(names, (0.2, 1.2)))
    genomes[0, -2:] = 0.2
    motion = robot.move(genomes)
    assert [*motion.failures] == [0]
    assert "collide in the standing pose" in motion.failures[0]
    with pytest.raises(GaitsimError, match=r"does not stand: its legs .* collide"):
        load_experiment("quadruped", {"organism.dimensions": dict.fromkeys(names, 0.2)})


MISTAKES = [
    ({"dimensions": {"shnk": 1.1}}, "unknown dimension 'shnk'"),
    ({"evolve": ["shin"]}, "unknown dimension 'shin'"),
    ({"dimensions": {"shank": 0.1}}, "invalid factor of the dimension 'shank': 0.1"),
    ({"evolve": ["shank"], "ranges": {"shank": [0.0, 1.0]}}, "invalid factor"),
    ({"evolve": ["shank"], "ranges": {"shank": [1.2, 0.8]}}, "is empty: 1.2 to 0.8"),
    ({"evolve": ["shank"], "ranges": {"thigh": [0.8, 1.2]}}, "that evolves"),
    ({"evolve": ["shank"], "dimensions": {"shank": 1.1}}, "both set and evolved"),
    ({"evolve": ["shank", "shank"]}, "listed twice: shank"),
]


@pytest.mark.parametrize(("options", "what"), MISTAKES, ids=str)
def test_a_mistake_is_one_message(options, what):
    overrides = {f"organism.{name}": value for name, value in options.items()}
    with pytest.raises(GaitsimError) as error:
        load_experiment("quadruped", overrides)
    [problem] = error.value.problems
    assert what in str(problem)
    assert "allowed" in str(problem) or "remove" in str(problem)


def test_closed_linkages_have_no_dimensions_and_say_so(tmp_path):
    path, overrides = mechanism(parallelogram, tmp_path), {"organism.dimensions": {"shank": 1.1}}
    with pytest.raises(GaitsimError, match="closed linkages or coupled joints"):
        load_experiment(str(path), overrides)


def test_the_message_names_joints_in_one_place(tmp_path):
    with pytest.raises(GaitsimError, match="these joints are in one place: FL_roll and FL_pitch"):
        load_file(tmp_path, QUADRUPED, dimensions={"hip": 1.1})


def test_designs_have_as_many_states_and_sensors(tmp_path):
    robot = Robot(model="quadruped")
    other = load_file(tmp_path, HEXAPOD)
    first, second = (robot.simulation.model.body(index).name for index in (2, 8))
    pair = f'<contact><exclude body1="{first}" body2="{second}"/></contact></mujoco>'
    # No other sizes, but another signature.
    same = Robot(model=robot.text.replace("</mujoco>", pair)).simulation
    assert same.model.signature != robot.simulation.model.signature
    assert robot.simulation.of_bodies([same]).bodies == (same,)
    with pytest.raises(RuntimeError, match="other bodies, joints or sensors"):
        robot.simulation.of_bodies([robot.simulation, other.simulation])


def test_mujoco_steps_the_design_as_the_population(tmp_path):
    """The states of a population with own models are those of `mj_step`, body by body."""
    robot, genomes = evolving("quadruped", ("thigh", "shank"), 3)
    motion = robot.move(genomes)
    body, genes = robot.embody(genomes[1])
    simulation = body.simulation
    from gaitsim_robot.rollout import delayed_commands

    commands = body._encoding.commands(genes[None], body.frames)[0]
    control = delayed_commands(simulation, commands, 0, body.frames - 1)[0]
    data = mujoco.MjData(simulation.model)
    state = mujoco.mjtState.mjSTATE_FULLPHYSICS
    mujoco.mj_setState(simulation.model, data, simulation.start, state)
    for step in control[:-1]:
        data.ctrl[:] = step
        mujoco.mj_step(simulation.model, data)
    assert np.array_equal(data.qpos, motion["configuration"][1, -1])
