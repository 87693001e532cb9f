"""The fly's options, controller, failures and skeleton."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from gaitsim.contracts import Motion
from gaitsim.evaluation import evaluate
from gaitsim.experiment import load_experiment
from gaitsim.network import Network
from gaitsim_fly import body
from gaitsim_fly.fitnesses import Climb, FinalAltitude, Hover, MeanAltitude
from gaitsim_fly.organism import Fly


def genomes(fly: Fly, count: int, seed: int = 0) -> Any:
    return fly.genome_space().random(count, np.random.default_rng(seed))


@pytest.mark.parametrize("activation", ["tanh", "sigmoid", "relu", "leaky-relu"])
@pytest.mark.parametrize(("wings", "hidden"), [("symmetric", (20, 20)), ("asymmetric", (7,))])
def test_the_wings_follow_the_network(activation: str, wings: str, hidden: tuple[int, ...]) -> None:
    fly = Fly(
        activation=activation,
        wings=wings,
        hidden=hidden,
        duration=0.5,
        trials=3,
        flap_limit=40,
        weight_sigma=1.0,
    )
    own = genomes(fly, 4)
    motion = fly.move(own)
    limits = np.tile(np.radians([40, 80, 30]), 2)
    quaternion = motion["rotation"]
    inputs = np.concatenate(
        [
            np.clip(motion["position"] / fly.position_scale, -1, 1),
            quaternion[..., 1:] * np.sign(quaternion[..., :1]),
            np.clip(motion["velocity"] / fly.velocity_scale, -1, 1),
            np.clip(motion["angular_velocity"] / fly.spin_scale, -1, 1),
            (motion["wing_angles"] / limits)[..., : 3 if wings == "symmetric" else 6],
        ],
        axis=-1,
    )
    network = Network.from_genes(fly.layers, own, activation, "tanh")
    columns = inputs.reshape(4, -1, fly.layers[0]).swapaxes(1, 2)
    wanted = network.activate(columns).swapaxes(1, 2).reshape(*inputs.shape[:3], -1)
    wanted = np.concatenate([wanted, wanted], axis=-1)[..., :6] * limits
    angles = motion["wing_angles"]
    farthest = fly.wing_speed * fly.control_step
    turned = np.clip(wanted - angles, -farthest, farthest)[:, :-1]
    np.testing.assert_allclose(np.diff(angles, axis=1), turned, atol=1e-6)
    assert (np.abs(angles) <= limits + 1e-12).all()


@pytest.mark.parametrize("wings", ["symmetric", "asymmetric"])
def test_an_individual_flies_the_same_alone_and_in_any_population(wings: Any) -> None:
    world = {name: one.high for name, one in Fly().conditions().items()}
    fly = Fly(trials=3, duration=0.3, wings=wings, world=world)
    own = genomes(fly, 45)
    together = fly.move(own)
    for part in (slice(0, 1), slice(7, 30), slice(44, 45)):
        alone = fly.move(own[part])
        for name in fly.channels:
            assert (alone[name] == together[name][part]).all(), name


def test_an_unstable_flight_fails_with_a_reason_without_affecting_others() -> None:
    # In a vacuum, nothing limits the speed of a falling fly.
    experiment = load_experiment(
        "fly",
        {
            "organism.gravity": 100,
            "organism.air_density": 0,
            "organism.duration": 5,
            "organism.trials": 2,
        },
    )
    own = genomes(experiment.organism, 3)  # type: ignore[arg-type]
    motion = experiment.organism.move(own)
    assert all(np.isfinite(motion[name]).all() for name in experiment.organism.channels)
    assert set(motion.failures) == {0, 1, 2}
    evaluation = evaluate(experiment, own)
    assert (evaluation.scores == -np.inf).all()
    assert "became unstable within 3.01 s in trial 1" in evaluation.reasons[2]
    assert all(np.isfinite(term).all() for term in evaluation.terms.values())


def test_all_starts_but_the_first_vary_and_are_reproducible() -> None:
    fly = Fly(wings="asymmetric", trials=4, duration=0.1)
    motion = fly.move(genomes(fly, 1))
    first = {name: motion[name][0, 0] for name in ("position", "velocity", "angular_velocity")}
    for name, values in first.items():
        assert (values[0] == 0).all(), name
        assert (np.abs(values[1:]) > 1e-3).all(), name
    assert (np.abs(first["position"]) <= fly.start_offset).all()
    assert (np.abs(first["velocity"]) <= fly.start_speed).all()
    other = Fly(wings="asymmetric", trials=4, duration=0.1, trial_seed=1)
    assert (fly.start_states() == Fly(wings="asymmetric", trials=4).start_states()).all()
    assert (other.start_states()[1:, :3] != fly.start_states()[1:, :3]).all()
    more = Fly(wings="asymmetric", trials=9).start_states()
    assert (more[:4] == fly.start_states()).all()


def test_homogeneous_matrices_move_the_skeleton() -> None:
    fly = Fly(wings="asymmetric", duration=1.0, trials=2)
    motion = fly.move(genomes(fly, 2))
    skeleton = fly.skeleton(motion, 1)
    lengths = np.linalg.norm(np.diff(skeleton.segments, axis=2)[:, :, 0], axis=-1)
    edge = np.hypot(fly.span, fly.chord / 2)
    expected = [*lengths[0, :12], *[edge, fly.chord, edge] * 2]
    np.testing.assert_allclose(lengths, np.broadcast_to(expected, lengths.shape), atol=1e-9)
    assert sorted(np.round(lengths[0, :12], 9)) == [0.1] * 8 + [0.3] * 4
    assert (skeleton.path == motion["position"][1, :, 0]).all()
    # Positive angles: up, leading edge up, forward.
    for angles, axis, corner in (((0.3, 0, 0), 2, 1), ((0, 0.3, 0), 2, 1), ((0, 0, 0.3), 0, 2)):
        for side in (1, -1):
            matrix = body.wing_matrix(np.array(angles, float), side, 0.05)
            tip = body.transform(matrix, body.wing_points(side, 0.5, 0.3))[corner]
            rest = body.wing_points(side, 0.5, 0.3)[corner] + [0, side * 0.05, 0]
            assert tip[axis] > rest[axis] + 0.01


def test_terms_follow_their_definitions() -> None:
    altitude = np.array([[[1.0, 2.0], [2.0, 2.0], [4.0, 8.0]]])
    position = np.stack([np.full((1, 3, 2), 3.0), -altitude, altitude], axis=-1)
    motion = Motion(100.0, {"altitude": altitude, "position": position})
    assert MeanAltitude().terms(motion)["altitude"] == pytest.approx([10 / 6])
    assert FinalAltitude().terms(motion)["altitude"] == pytest.approx([(3 + 6) / 2])
    climb = Climb().terms(motion)
    assert climb["altitude"] == pytest.approx([4.5])
    assert climb["drift"] == pytest.approx([-10 / 6 / 5])
    hover = Hover(x=3, y=-2, z=2, radius=0.5).terms(motion)
    assert hover["within"] == pytest.approx([3 / 6])
    away = np.sqrt([2, 0, 0, 0, 8, 72])
    assert hover["nearness"] == pytest.approx([np.mean(0.5 / (0.5 + away))])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dt": 0.003}, "'control_step', 0.01 s, .* 'dt', 0.003 s"),
        ({"dt": 0.01, "wing_speed": 40.0}, "0.00111"),
        ({"control_step": 0.0007}, "'control_step', 0.0007 s"),
        ({"duration": 0.005}, "'duration', 0.005 s"),
        ({"duration": 600, "dt": 1e-6}, "600,000,000 steps, but at most 2,000,000"),
        ({"hidden": (1, 2, 3, 4, 5)}, "'hidden' has 5"),
        ({"flap_limit": 91.0}, "flap_limit\n.*90"),
        ({"hidden": (20, 0)}, "hidden.1\n.* 1 "),
    ],
)
def test_invalid_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Fly(**options)
