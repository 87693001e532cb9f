"""The spider's kernels as WebAssembly, from the code that Numba compiles for this computer.

`python -m gaitsim_page.kernels` builds `assets/spider.wasm` after a change of the kernels. Numba's
intermediate code, before any optimisation, is compiled for another target. WebAssembly defines the
result of each operation, and has none that fuses a product and a sum, so the module gives the bits
of the kernels here.
"""

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim_spider.body import FRAMES, JOINTS, LEGS
from gaitsim_spider.intervals import BLOCK, whole_blocks
from gaitsim_spider.sums import STATE

FILE = "spider.wasm"
MOST_DRAWS = 512  # in one call of `normals`
STRIPS = 256

MEMORY = np.dtype(
    [
        ("block", BLOCK, (1,)),
        ("states", STATE, (1,)),
        # A genome, decoded, and the sums of the terms of its score.
        ("amplitude", np.float64, (1, len(JOINTS))),
        ("phase", np.float64, (1, len(LEGS))),
        ("lag", np.float64, (1, len(JOINTS))),
        ("sums", np.float64, (1, 8)),
        # Constants of the body and of the fitness.
        ("gain", np.float64),
        ("poles", np.float32, (2, 2)),
        ("safe_margin", np.float32),
        ("sine", np.float32, (FRAMES,)),
        ("cosine", np.float32, (FRAMES,)),
        ("lengths", np.float32, (1, len(LEGS), 3)),
        ("shares", np.float32, (1, len(LEGS), 3)),
        ("hips", np.float32, (1, len(LEGS), 3)),
        ("moments", np.float32, (1, 3)),
        ("lost", np.uint8, (len(LEGS),)),
        # The motion.
        ("angles", np.float32, (1, len(JOINTS), FRAMES)),
        ("feet", np.float32, (1, 3, len(LEGS), whole_blocks(FRAMES))),
        ("centre", np.float32, (1, 3, whole_blocks(FRAMES))),
        ("pose", np.float32, (1, 3, FRAMES)),
        ("stance", np.uint8, (1, len(LEGS), FRAMES)),
        ("slip", np.float32, (1, FRAMES)),
        ("margin", np.float32, (1, FRAMES)),
        ("slope", np.float32, (1, FRAMES)),
        # Arguments and result of an elementary function.
        ("x", np.float64),
        ("y", np.float64),
        ("result", np.float64),
        # Normal draws; see gaitsim/portable/normal.py.
        ("draws", np.int64),
        ("bits", np.uint64, (2 * MOST_DRAWS,)),
        ("widths", np.float64, (STRIPS,)),
        ("limits", np.uint64, (STRIPS,)),
        ("heights", np.float64, (STRIPS,)),
        ("normals", np.float64, (MOST_DRAWS,)),
    ],
    align=True,
)
"""The memory that the module's functions read and write."""


def build() -> bytes:
    """Return the module, with one exported function for each of `_functions`.

    Each takes the addresses of two scratch words and of `MEMORY`. The module imports the memory
    `env.__linear_memory` and the global `env.__stack_pointer`.
    """
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple("wasm32-unknown-unknown")
    features = "+simd128,+bulk-memory"
    machine = target.create_target_machine(cpu="generic", features=features, opt=3)
    texts = dict(_intermediate(str(machine.target_data), target.triple))
    modules = [llvm.parse_assembly(text) for text in texts.values()]
    module = modules[0]
    for other in modules[1:]:
        module.link_in(other)
    options = llvm.create_pipeline_tuning_options(3)
    options.loop_vectorization = options.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    defined = [one.name for one in module.functions if not one.is_declaration]
    return _exported(machine.emit_object(module), {name: defined.index(name) for name in texts})


def _functions() -> dict[str, Callable[[Any], None]]:
    """Return functions of `MEMORY` by the names of their exports."""
    import numba

    from gaitsim.plugin.toolkit import compiled, normal_fill as fill, scalar
    from gaitsim_spider.damage import LegData
    from gaitsim_spider.sums import sum_frames
    from gaitsim_spider.walking import walk
    from gaitsim_spider.waves import sum_waves

    carray: Any = numba.carray  # type: ignore[attr-defined]

    def evaluate(address: Any) -> None:
        m = carray(address, 1)[0]
        sum_waves(m.sine, m.cosine, m.amplitude, m.phase, m.lag, m.angles)
        for leg in range(8):
            for joint in range(3 * leg, 3 * leg + 3):
                for frame in range(m.angles.shape[2] if m.lost[leg] else 0):
                    m.angles[0, joint, frame] = np.float32(0.0)
        legs = LegData(m.lengths, m.shares, m.hips, m.moments)
        outputs = m.feet, m.centre, m.block, m.pose, m.stance, m.slip, m.margin, m.slope
        walk(m.angles, legs, None, *outputs)
        motion = m.pose, m.slip, m.margin, m.slope, m.angles
        sum_frames(*motion, m.safe_margin, m.gain, m.poles, m.states, m.sums)

    def exp(address: Any) -> None:
        m = carray(address, 1)[0]
        m.result = compiled.exp(m.x)

    def log(address: Any) -> None:
        m = carray(address, 1)[0]
        m.result = compiled.log(m.x)

    def power(address: Any) -> None:
        m = carray(address, 1)[0]
        m.result = scalar.power(m.x, m.y)

    def normals(address: Any) -> None:
        m = carray(address, 1)[0]
        m.result = fill(m.bits, m.widths, m.limits, m.heights, m.normals[: m.draws])

    return {one.__name__: one for one in (evaluate, exp, log, power, normals)}


_NAME = r'@(?:"([^"]*)"|((?:_ZN|cfunc\._ZN|numba\.|\.const)[\w.$]*))'


def _intermediate(layout: str, triple: str) -> Iterator[tuple[str, str]]:
    """Yield the names of the functions and their intermediate code for a target."""
    from numba import from_dtype, njit, types

    pointer: Any = types.CPointer
    signature = (pointer(from_dtype(MEMORY)),)
    for name, function in _functions().items():
        compiled = njit(error_model="numpy")(function)
        compiled.compile(signature)
        found: Any = compiled.overloads[signature]
        # The names of Numba's functions contain all fields of the memory.
        short: dict[str, str] = {found.fndesc.llvm_func_name: name}

        def shortened(match: re.Match[str], name: str = name, short: dict[str, str] = short) -> str:
            return "@" + short.setdefault(match[1] or match[2], f"{name}_{len(short)}")

        text = str(found.library._final_module)
        text = re.sub(_NAME, shortened, text)
        text = re.sub("target datalayout.*", f'target datalayout = "{layout}"', text)
        text = re.sub("target triple.*", f'target triple = "{triple}"', text)
        text = re.sub(r"@sqrtf\(", "@llvm.sqrt.f32(", re.sub(r"@sqrt\(", "@llvm.sqrt.f64(", text))
        # Nothing is allocated, so there is nothing to count references to.
        text = re.sub(r"call void @NRT_(in|de)cref\(.*", "", text)
        # All but the function itself is dropped if it is unused.
        text = re.sub(r"^define (linkonce_odr |internal )?", "define internal ", text, flags=re.M)
        text = re.sub(r"= (common|linkonce) (\S+ )?global", "= internal global", text)
        yield name, re.sub(f"^define internal (.*@{name}\\()", r"define \1", text, flags=re.M)


_CUSTOM, _EXPORTS, _CODE = 0, 7, 10


def _exported(data: bytes, functions: dict[str, int]) -> bytes:
    """Return an object file as a module that exports functions, without debugging sections.

    The only object file of a module needs no linker, as all its addresses are final.

    Args:
        data: object file, without imported functions.
        functions: names of functions, and their positions among the defined ones.
    """
    names = ((name.encode(), position) for name, position in functions.items())
    entries = [_sized(name) + b"\x00" + _leb(position) for name, position in names]
    exports = bytes([_EXPORTS]) + _sized(_leb(len(entries)) + b"".join(entries))
    found, place = [data[:8]], 8
    while place < len(data):
        kind, (size, start) = data[place], _read_leb(data, place + 1)
        place, section = start + size, data[place : start + size]
        if kind >= _CODE and exports not in found:
            found.append(exports)
        found += [section] if kind != _CUSTOM else []
    return b"".join(found)


def _sized(data: bytes) -> bytes:
    return _leb(len(data)) + data


def _leb(number: int) -> bytes:
    """Return a number in groups of seven bits, the lowest first."""
    low, rest = number & 127, number >> 7
    return bytes([low | 128]) + _leb(rest) if rest else bytes([low])


def _read_leb(data: bytes, place: int) -> tuple[int, int]:
    """Return the number at a place, and the place after it."""
    number = shift = 0
    while True:
        number |= (data[place] & 127) << shift
        place, shift = place + 1, shift + 7
        if data[place - 1] < 128:
            return number, place


def main() -> None:
    """Build the module."""
    import numba

    # Numba's own optimisations are for this computer.
    options = {"NUMBA_OPT": "0", "NUMBA_LOOP_VECTORIZE": "0", "NUMBA_CPU_NAME": "generic"}
    os.environ.update(options)
    numba.config.reload_config()  # type: ignore[no-untyped-call]
    (Path(__file__).parent / "assets" / FILE).write_bytes(build())


if __name__ == "__main__":
    main()
