"""Each bundled reflex computes the same in C99 as in Python."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from bench import INTERVAL, LEGS, inputs_of, observation

from gaitsim.registry import entries, load_class

HEAD = """
#include <math.h>
#define GAIT_LEGS 4
static double gait_clip(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}
"""
COMPILER = shutil.which("cc")


def struct(name, values):
    """Return the declaration of a struct of numbers and arrays of an individual, in this order."""
    sizes = {key: np.size(value) for key, value in values.items()}
    array = {key: f"[{sizes[key]}]" if np.ndim(value) else "" for key, value in values.items()}
    lines = [f"double {key}{array[key]};" for key in values] or ["double unused;"]
    return f"typedef struct {{ {' '.join(lines)} }} {name};\n"


def flat(values):
    return np.concatenate([np.ravel(value) for value in values.values()] or [np.zeros(1)])


def pointer(values):
    return values.ctypes.data_as(ctypes.c_void_p)


@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
@pytest.mark.parametrize("name", entries("reflex"))
def test_c_computes_the_same(tmp_path, name):
    reflex, rng = load_class("reflex", name)(), np.random.default_rng(5)
    state = reflex.start(LEGS, rng.uniform(-1, 1, (1, reflex.weights(LEGS))))
    options = {key: float(value) for key, value in dict(reflex).items()}

    def values(of):
        return {key: array[0] for key, array in vars(of).items()}

    seen = observation()
    seen.duty = seen.duty[:, 0]
    source = (
        HEAD + struct("Options", options) + struct("State", {k: v[0] for k, v in state.items()})
    )
    source += struct("Seen", values(seen)) + struct("Inputs", values(inputs_of(observation())))
    source += (
        "void step(const Options *o, State *s, const Seen *seen, Inputs *inputs, double interval)\n"
        f"{{\n(void)o; (void)s; (void)seen; (void)interval; (void)gait_clip;\n{reflex.c99()}}}\n"
    )
    (tmp_path / "reflex.c").write_text(source)
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    library = tmp_path / "reflex.so"
    command = [COMPILER, *flags, "-o", str(library), str(tmp_path / "reflex.c"), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    function = ctypes.CDLL(str(library)).step
    function.argtypes, function.restype = [ctypes.c_void_p] * 4 + [ctypes.c_double], None

    inside, held = flat({key: value[0] for key, value in state.items()}), flat(options)
    for turn in range(300):
        seen = observation(
            orientation=rng.normal(0, 0.3, (1, 3)),
            rates=rng.normal(0, 1, (1, 3)),
            contacts=rng.integers(2, size=(1, 4)),
            load=rng.random((1, 4)),
            heading=rng.normal(0, 3, 1),
            phase=rng.random((1, 4)),
            duty=rng.uniform(0.3, 0.8, (1, 1)),
            command=rng.normal(0, 0.1, (1, 4)) * (turn % 10 > 0),
        )
        inputs = inputs_of(seen)
        felt, changed = flat(values(seen)), flat(values(inputs))
        reflex.step(state, seen, inputs, INTERVAL)
        function(pointer(held), pointer(inside), pointer(felt), pointer(changed), INTERVAL)
        assert changed == pytest.approx(flat(values(inputs)), rel=1e-12, abs=1e-14)
    if state:
        assert inside == pytest.approx(flat(state), rel=1e-12, abs=1e-14)
