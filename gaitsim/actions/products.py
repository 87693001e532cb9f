"""Parts shared by plots and exports: the plugin that a switch names, and its options."""

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic.fields import FieldInfo

from gaitsim.actions.action import (
    OneIndividual,
    SeveralIndividuals,
    individual_options,
)
from gaitsim.contracts.product import Product
from gaitsim.errors import GaitsimError, nearest, unsupported_flags
from gaitsim.registry import entries
from gaitsim.registry.entry_points import install_hint
from gaitsim.registry.loading import load_class, products
from gaitsim.registry.options import flag, validated

SWITCHES = {"plot": "--kind", "exporter": "--format"}
"""The flag that names a plugin, by its kind."""
ALL = "all"
"""The kind that stands for all kinds of plots."""
_SUBJECTS = {"plot": "a plot of kind {!r}", "exporter": "the format {!r}"}


def fields(product: type[Product]) -> dict[str, FieldInfo]:
    """Return the options of a product: its own, and those that choose individuals."""
    chosen = SeveralIndividuals.model_fields
    common = {name: chosen[name] for name in individual_options(product.input)}
    return product.model_fields | common


def read_product(
    kind: str, name: str, given: Mapping[str, Any]
) -> tuple[SeveralIndividuals, Product]:
    """Return the choice of individuals and the plugin with its options.

    Args:
        kind: 'plot' or 'exporter'.
        name: name of the plugin.
        given: values of the options by name, without unset ones.

    Raises:
        GaitsimError: the plugin is unknown, does not have an option, or an option is invalid.
    """
    if name not in (known := [*entries(kind)]):
        switch = SWITCHES[kind]
        allowed = [*known, ALL] if kind == "plot" else known
        raise GaitsimError(
            f"invalid {switch}: {name!r}",
            where=switch,
            allowed=", ".join(allowed),
            remedy=install_hint(kind, name) or nearest(name, allowed),
        )
    product: type[Product] = load_class(kind, name)  # type: ignore[assignment]
    _check_supported(kind, name, given, fields(product))
    own = {one: value for one, value in given.items() if one in product.model_fields}
    chosen = {one: value for one, value in given.items() if one not in own}
    return validated(SeveralIndividuals, chosen), validated(product, own)


def fields_of_all(kind: str) -> dict[str, FieldInfo]:
    """Return the options of all plugins of a kind at once, for one individual."""
    every = products(kind).values()
    known = {name: field for one in every for name, field in fields(one).items()}
    return {name: field for name, field in known.items() if name != "generations"}


def read_all(kind: str, given: Mapping[str, Any]) -> tuple[SeveralIndividuals, dict[str, Product]]:
    """Return the choice of an individual and all plugins of a kind, each with its options.

    Raises:
        GaitsimError: no plugin has an option, several individuals are chosen, or an option is
            invalid.
    """
    every = products(kind)
    _check_supported(kind, "all", given, fields_of_all(kind))
    chosen = {name: value for name, value in given.items() if name in OneIndividual.model_fields}
    found = {}
    for name, product in every.items():
        own = {one: value for one, value in given.items() if one in product.model_fields}
        if "channel" in own and name != "channel":
            del own["channel"]  # which would be the same plot again
        found[name] = validated(product, own)
    return validated(SeveralIndividuals, chosen), found


def _check_supported(
    kind: str, name: str, given: Mapping[str, Any], known: Mapping[str, FieldInfo]
) -> None:
    """Check that a plugin has all given options."""
    unused = [one for one in given if one not in known]
    if not unused:
        return
    every = {other: fields(product) for other, product in products(kind).items()}
    declared = {one: field for other in every.values() for one, field in other.items()}
    raise unsupported_flags(
        _SUBJECTS[kind].format(name),
        [flag(one, declared[one]) for one in unused],
        SWITCHES[kind],
        [other for other, one in every.items() if {*unused} <= {*one}],
        allowed=", ".join(sorted(flag(one, field) for one, field in known.items())),
    )


def individual_fields(kind: str) -> Iterator[tuple[str, FieldInfo, list[str]]]:
    """Yield the options that choose individuals, with the plugins that alone have them."""
    every = products(kind).items()
    several = [name for name, product in every if product.input == "individuals"]
    for name, field in SeveralIndividuals.model_fields.items():
        yield name, field, several if name not in OneIndividual.model_fields else []


def all_fields(kind: str) -> Iterator[tuple[str, FieldInfo, list[str]]]:
    """Yield the options of all plugins of a kind, with the plugins that alone have them."""
    found: dict[str, tuple[FieldInfo, list[str]]] = {}
    every = products(kind)
    for name, product in sorted(every.items(), key=lambda one: _is_foreign(kind, one[0])):
        for option, field in product.model_fields.items():
            found.setdefault(option, (field, []))[1].append(name)
    for option, (field, owners) in found.items():
        yield option, field, owners if len(owners) < len(every) else []


def _is_foreign(kind: str, name: str) -> bool:
    """Return whether another package provides a plugin; its options do not replace gaitsim's."""
    return entries(kind)[name][0].package != "gaitsim"


def describe(kind: str) -> str:
    """Return the names of all plugins of a kind by group, for the help of a command."""
    groups: dict[str, list[str]] = {}
    for name, product in products(kind).items():
        note = f" ({product.note})" if product.note else ""
        groups.setdefault(product.group, []).append(f"{name}{note}")
    return "\n\n".join(f"{group}: {', '.join(names)}" for group, names in groups.items())
