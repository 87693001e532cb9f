"""Plugins are listed without importing them, and a broken plugin does not affect others."""

import pickle

import pytest

from gaitsim import registry
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.registry import EXPERIMENTS, KINDS, Entry, plugin_errors

ENTRY = Entry("organism", "hopper", "fake:Hopper", "fake", "1.0")


@pytest.mark.parametrize("kind", [*KINDS, EXPERIMENTS])
def test_each_kind_has_bundled_entries(kind):
    assert len(registry.entries(kind)) >= 1
    assert list(registry.entries(kind)) == sorted(registry.entries(kind))


def test_names_are_listed_without_an_import(install, tmp_path):
    marker = tmp_path / "imported"
    install(
        "fake",
        f"import pathlib\npathlib.Path({str(marker)!r}).touch()\nraise RuntimeError('imported')",
        {kind: {"hopper": "Hopper"} for kind in KINDS},
    )
    for kind in KINDS:
        (entry,) = registry.entries(kind)["hopper"]
        assert entry == Entry(kind, "hopper", "fake:Hopper", "fake", "1.0")
        assert registry.find(kind, "hopper") == entry
    assert not marker.exists()
    with pytest.raises(PluginError, match="RuntimeError: imported"):
        registry.load_class("organism", "hopper")
    assert marker.exists()


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("import no_such_module_at_all", "No module named 'no_such_module_at_all'"),
        ("def (", "SyntaxError"),
        ("import sys; sys.exit(0)", "SystemExit: 0"),
        ("def f(): f()\nf()", "RecursionError"),
        ("class E(BaseException): pass\nraise E('odd')", "E: odd"),
        ("class E(Exception):\n    def __str__(self): 1 / 0\nraise E", "E"),
        (
            "from gaitsim.contracts import Crossover\nclass Hopper(Crossover):\n    children = 1\n",
            "'children'",
        ),
    ],
)
def test_a_broken_plugin_is_contained_and_named(install, working, source, reason):
    install("fake", source or "x = 1", {"organism": {"hopper": "Hopper"}})
    install("other", working, {"organism": {"point": "Body"}})
    with pytest.raises(GaitsimError) as raised:
        registry.load_class("organism", "hopper")
    assert "package fake 1.0" in str(raised.value)
    assert reason in str(raised.value)
    classes, failures = registry.scan("organism")
    assert {"spider", "point"} <= set(classes)
    assert "hopper" not in classes
    assert {name: str(error) for name, error in failures.items()} == {"hopper": str(raised.value)}


def test_an_interrupt_during_an_import_is_raised(install):
    install("fake", "raise KeyboardInterrupt", {"organism": {"hopper": "Hopper"}})
    with pytest.raises(KeyboardInterrupt):
        registry.load_class("organism", "hopper")


def test_a_name_of_two_packages_is_refused_and_both_are_named(install, working):
    install("one", working, {"organism": {"point": "Body", "only-one": "Body"}})
    install("two", working, {"organism": {"point": "Body"}}, version="2.5")
    with pytest.raises(PluginError) as raised:
        registry.find("organism", "point")
    assert "one 1.0" in str(raised.value)
    assert "two 2.5" in str(raised.value)
    classes, failures = registry.scan("organism")
    assert {"spider", "only-one"} <= set(classes)
    assert "point" not in classes
    assert [*failures] == ["point"]


def test_a_bundled_name_cannot_be_taken(install, working):
    install("fake", working, {"organism": {"spider": "Body"}})
    with pytest.raises(PluginError, match=r"gaitsim .*fake|fake .*gaitsim"):
        registry.load_class("organism", "spider")
    assert registry.load_class("selection", "truncation")


@pytest.mark.parametrize(
    ("target", "reason"),
    [
        ("Distance", "not a subclass of Organism, but the class Distance"),
        ("np", "not a subclass of Organism, but a module"),
        ("option", "but a function"),
        ("Organism", "does not implement genome_space, move, skeleton"),
    ],
)
def test_an_object_that_is_not_a_plugin_of_the_kind_is_refused(install, working, target, reason):
    install("fake", working, {"organism": {"hopper": target}})
    with pytest.raises(PluginError) as raised:
        registry.load_class("organism", "hopper")
    assert "package fake 1.0" in str(raised.value)
    assert reason in str(raised.value)


@pytest.mark.parametrize(
    ("kind", "source", "reason"),
    [
        ("organism", "class X(Body):\n    channels = None", "channels must be"),
        (
            "organism",
            "class X(Body):\n    channels = {'way': '(population,) m'}",
            "channels must be",
        ),
        (
            "organism",
            "class X(Body):\n    channels = {'joint_angles': Channel(('frames',), 'rad', '')}",
            "joint_angles must be Channel",
        ),
        ("fitness", "class X(Distance):\n    needs = 'distance'", "needs must be"),
        ("crossover", "class X(Solo):\n    children: ClassVar[int] = 3", "children must be 1 or 2"),
        ("mutation", "class X(Still):\n    spaces: ClassVar = ('real',)", "spaces must be"),
        ("selection", "class X(First):\n    plugin: int = 3", "named 'plugin'"),
    ],
)
def test_a_wrong_declaration_is_refused(install, working, kind, source, reason):
    source = source.replace("channels =", "channels: ClassVar =")
    source = source.replace("needs =", "needs: ClassVar =")
    install("fake", f"{working}\n{source}\n", {kind: {"x": "X"}})
    with pytest.raises(PluginError, match=reason) as raised:
        registry.load_class(kind, "x")
    assert "package fake 1.0" in str(raised.value)


def test_a_fitness_without_needs_is_refused(install):
    source = (
        "from gaitsim.contracts import Fitness\n"
        "class X(Fitness):\n    def terms(self, motion): return {}\n"
    )
    install("fake", source, {"fitness": {"x": "X"}})
    with pytest.raises(PluginError, match="needs must be"):
        registry.load_class("fitness", "x")


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(PluginError) as raised:
        registry.find("organism", "spidr")
    assert "did you mean 'spider'?" in str(raised.value)
    assert "spider" in raised.value.allowed


@pytest.mark.parametrize(
    "points", [b"[gaitsim.organism]\nno equals sign\n", b"[gaitsim.organism]\n\xe9 = fake:Body\n"]
)
def test_damaged_entry_points_of_one_package_leave_the_others(install, working, points):
    folder = install("damaged", files={"damaged-1.0.dist-info/entry_points.txt": points})
    install("whole", working, {"organism": {"point": "Body"}})
    assert {"spider", "point"} <= set(registry.entries("organism"))
    assert registry.load_class("organism", "point").__name__ == "Body"
    assert registry.unreadable() == [f"damaged in {folder}"]


@pytest.mark.parametrize("metadata", [b"", b"Name: f\xe9\nVersion: 1\n"])
def test_damaged_metadata_leaves_the_entries(install, working, metadata):
    files = {"fake-1.0.dist-info/METADATA": metadata}
    install("fake", working, {"organism": {"point": "Body"}}, files=files)
    entry = registry.find("organism", "point")
    assert entry.package
    assert str(entry).startswith("organism 'point' of package ")
    assert registry.load_class("organism", "point").__name__ == "Body"


def test_an_error_keeps_its_cause_and_survives_pickling():
    with pytest.raises(PluginError) as raised, plugin_errors(ENTRY, "moving"):
        raise ValueError("too heavy")
    assert isinstance(raised.value.__cause__, ValueError)
    copy = pickle.loads(pickle.dumps(raised.value))
    assert str(copy) == str(raised.value)
    assert "failed while moving: ValueError: too heavy" in str(copy)
    assert "where:   fake:Hopper" in str(copy)
