"""Results of a map of designs: tables for people, JSON and CSV for programs."""

import csv
import io
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin.commands import as_json, output, print_table
from gaitsim.plugin.pictures import number
from gaitsim.plugin.runs import command, exports_folder, write_bytes
from gaitsim_design.maps import COST, HEAT, SPEED, DesignMap
from gaitsim_design.statistics import SearchNoise, shares

JSON, CSV = "results.json", "designs.csv"
MARKS = {1: " ▲", -1: " ▼", 0: ""}  # of differences from the original
FEW = 12  # failed designs that are listed


def write_results(found: DesignMap) -> list[Path]:
    """Write `results.json` and `designs.csv` to the exports of the run; return their paths."""
    folder = exports_folder(found.run.path)
    texts = {JSON: json.dumps(json.loads(as_json(to_dict(found))), indent=1), CSV: table(found)}
    for name, text in texts.items():
        write_bytes(folder / name, f"{text.rstrip()}\n".encode(), follow=False)
    return [folder / name for name in texts]


def table(found: DesignMap) -> str:
    """Return a row for each design as CSV.

    The columns are factors and values of the dimensions; whether the design is the original and on
    the plateau; and mean, ends of the 95 % interval, and the comparison with the original of each
    quantity: 1 above, −1 below, 0 within the noise of the search.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    sizes = [f"{name} ({one.unit})" if one.unit else name for name, one in found.dimensions.items()]
    factors = [f"{name} factor" for name in found.names]
    parts = ("", " low", " high", " vs original")
    measured = [f"{name}{part}" for name in found.quantities for part in parts]
    writer.writerow(["design", *factors, *sizes, "original", "plateau", "member", *measured])
    nominal = np.array([one.nominal for one in found.dimensions.values()])
    for index, row in enumerate(found.designs.tolist()):
        cells: list[Any] = [index + 1, *row, *(np.array(row) * nominal).tolist()]
        cells += [int(index == found.original), int(found.plateau[index]), found.member(index)]
        for one in found.quantities.values():
            middle, half = float(one.means[index]), float(one.half_widths[index])
            cells += [middle, middle - half, middle + half, int(one.differs[index])]
        writer.writerow(
            ["" if isinstance(cell, float) and math.isnan(cell) else cell for cell in cells]
        )
    return text.getvalue()


def to_dict(found: DesignMap) -> dict[str, Any]:
    """Return the results for JSON."""
    search = found.search
    quantities = {}
    for name, quantity in found.quantities.items():
        share, ends, r_squared = shares(found.points, quantity.values)
        quantities[name] = {
            "unit": quantity.unit,
            "higher_is_better": quantity.higher,
            "values": quantity.values.tolist(),
            "mean": quantity.means.tolist(),
            "half_width": quantity.half_widths.tolist(),
            "vs_original": quantity.differs.tolist(),
            "noise": SearchNoise.of(quantity.values).deviations.tolist(),
            "variance_explained": dict(zip(found.names, share.tolist(), strict=True)),
            "variance_range": dict(zip(found.names, ends.T.tolist(), strict=True)),
            "r_squared": r_squared,
        }
    rated, known = found.heat_share
    return {
        "run": str(found.run.path),
        "generation": found.run.generation,
        "generations": found.experiment.evolution.generations,
        "dimensions": {name: asdict(one) for name, one in found.dimensions.items()},
        "designs": found.designs.tolist(),
        "members": [found.member(index) for index in range(len(found.designs))],
        "original": found.original,
        "best": found.best,
        "plateau": np.flatnonzero(found.plateau).tolist(),
        "replicates": search.replicates,
        "speed": search.speed or None,
        "continuous_share": {"value": rated, "known": known},
        "quantities": quantities,
        "failures": {str(index): reason for index, reason in found.failures().items()},
        "servos": {
            name: [{**one._asdict(), "holds": one.holds} for one in loads]
            for name, loads in found.servo_loads.items()
        },
    }


def print_map(found: DesignMap, files: list[Path]) -> None:
    """Print the best designs, which dimensions matter, the plateau and the servos."""
    console, search = output(), found.search
    count = len(found.designs)
    console.print(
        f"{found.run.path}: {count:,} designs in {', '.join(found.names)}; "
        f"{search.replicates} replicate{'s' * (search.replicates > 1)}",
        style="bold",
    )
    _print_chosen(found)
    console.print()
    _print_dimensions(found)
    console.print()
    for line in _plateau_lines(found):
        console.print(line)
    if found.servo_loads:
        console.print()
        _print_servos(found)
    console.print()
    for line in _notes(found):
        console.print(line, style="dim")
    best = Path(found.run.path), "--member", found.member(found.best)
    for purpose, line in {
        "watch the best design": command("play", *best),
        "show it on a plot": command("plot", found.run.path, "--kind", "design"),
    }.items():
        console.print(f"  {line}  # {purpose}", style="dim", soft_wrap=True)
    for path in files:
        console.print(str(path), soft_wrap=True)


def _print_chosen(found: DesignMap) -> None:
    """Print the original and the best designs, with intervals; a mark shows a difference."""
    head = []
    for name, one in found.quantities.items():
        head.append(f"{name} ({one.unit})" if one.unit and " " not in one.unit else name)
    rows = []
    for label, index in found.chosen.items():
        row = [label, found.label(index)]
        for one in found.quantities.values():
            mean, half = float(one.means[index]), float(one.half_widths[index])
            more = f" ± {number(half)}" if math.isfinite(half) else ""
            row.append(f"{number(mean)}{more}{MARKS[int(one.differs[index])]}")
        rows.append(row)
    print_table(["", "design", *head], rows, head)


def _print_dimensions(found: DesignMap) -> None:
    """Print the share of each dimension in the variance of each quantity, and R²."""
    columns = [name for name in ("score", SPEED, COST, HEAT) if name in found.quantities]
    each = {name: shares(found.points, found.quantities[name].values) for name in columns}
    rows = [
        [name, *(_share(share[index], *ends[:, index]) for share, ends, _ in each.values())]
        for index, name in enumerate(found.names)
    ]
    rows.append(["R² of the surface", *(_percent(one) for *_, one in each.values())])
    print_table(["share of the variance", *columns], rows, columns)


def _plateau_lines(found: DesignMap) -> list[str]:
    """Return sentences about the plateau, the original and the noise of the search."""
    on, original = found.plateau, found.original
    if found.search.replicates < 2:
        return ["One replicate shows no noise of the search; use --replicates for a plateau."]
    ends = ", ".join(
        f"{name} {least:.3g} to {most:.3g}"
        for name, least, most in zip(
            found.names, found.designs[on].min(axis=0), found.designs[on].max(axis=0), strict=True
        )
    )
    where = "on it" if on[original] else "below it"
    score = found.quantities["score"]
    differs = score.differs
    low, middle, high = np.nanquantile(SearchNoise.of(score.values).deviations, [0, 0.5, 1])
    lines = [
        f"Plateau: the scores of {int(on.sum())} of {len(on)} designs cannot be distinguished from "
        f"the best: {ends}. The original is {where}.",
        "Noise of the search: standard deviations of single designs "
        f"{number(float(low))} to {number(float(high))}, median {number(float(middle))}. "
        f"{int((differs > 0).sum())} designs score above the original, {int((differs < 0).sum())} "
        "below.",
    ]
    failures = found.failures()
    if failures:
        lines.append(f"{len(failures)} designs do not walk:")
        lines += [f"  {found.label(one)}: {text}" for one, text in [*failures.items()][:FEW]]
    return lines


def _print_servos(found: DesignMap) -> None:
    """Print the load of each servo of the table with the gaits of the chosen designs."""
    columns = [*found.servo_loads]
    rows = []
    for loads in zip(*found.servo_loads.values(), strict=True):
        row = [loads[0].servo]
        for one in loads:
            mark = "✓" if one.holds else "✗"
            fell = "" if one.lasted else ", falls"
            row.append(
                f"{mark} heat {one.heat:.0%}, peak {one.peak:.0%}, {one.speed:.2f} m/s{fell}"
            )
        rows.append(row)
    print_table(["servo", *columns], rows)


def _notes(found: DesignMap) -> list[str]:
    """Return what the figures assume."""
    search, experiment = found.search, found.experiment
    lines = [
        "± is the 95 % interval of the mean over replicates; ▲ and ▼ mark differences from the "
        "original beyond the noise of the search, at most 5 % of them false. Shares of the "
        "variance are first-order indices of a quadratic surface, in brackets for each replicate."
    ]
    worlds = experiment.worlds.count
    if worlds:
        kind = {"mean": "the mean over", "worst": "those in the worst of"}.get(
            experiment.worlds.combine, "means over the worst of"
        )
        lines.append(f"Scores and measures are {kind} {worlds} worlds; servos: the nominal world.")
    if HEAT in found.quantities:
        share, known = found.heat_share
        of = "the servos' own" if known else "assumed, as the servos' own is unknown"
        lines.append(
            f"heat: RMS torque of the hottest servo as a share of the continuous torque, {share:g} "
            f"of the stall torque ({of}); heat and cost of transport hold at the speed of the row."
        )
    if search.speed:
        slow = found.quantities[SPEED].means < search.speed
        lines.append(
            f"Gaits should reach {search.speed:g} m/s; {int(slow.sum())} designs are slower."
        )
    last, planned = found.run.generation, experiment.evolution.generations
    if last < planned:
        lines.append(f"Not finished: generation {last} of {planned}.")
    return lines


def _percent(value: float) -> str:
    return f"{value:.0%}" if math.isfinite(value) else "–"


def _share(value: float, low: float, high: float) -> str:
    return f"{value:.0%} ({low:.0%} to {high:.0%})" if math.isfinite(value) else "–"
