"""Evolve gaits, look at them, and bring them elsewhere.

A session in Python, from a preset to a file:

    import gaitsim as gs
    gs.presets()                                    # what can evolve
    for generation in gs.evolve("spider", out="runs/spider"):
        print(generation)                           # best and mean score
    run = gs.load("spider")                         # gs.runs() lists all
    run.champion.gait, run.champion.measures        # gs.analyse(run): a table
    run.plot("fitness"), run.champion.plot("path"), gs.view(run.champion)
    run.replay(5, damage="L2 lost").motion["feet"]  # arrays with units
    run.to_pandas(), run.champion.to_pandas()       # history, motion
    run.export("gait.csv"), run.video("gait.mp4")
    gs.verify(run), gs.verify(gs.share(run))        # bit for bit
"""

# Under a private name, as some editors offer all names of the file for completion.
from gaitsim import surface as _surface

# The stub lists the names, which are imported at first use: `gaitsim --help` needs none of these
# modules, nor NumPy.
_load, _names = _surface.offer(__name__, __file__)
__all__ = _names()  # noqa: PLE0605 - names, which a linter cannot see
# Packages add functions by the entry points `gaitsim.python`.

# Names that users guess for others; each thing has one name.
_GUESSED = {
    "experiments": "presets()",
    "list_presets": "presets()",
    "list_runs": "runs()",
    "open": "load(NAME)",
    "plot": "load(NAME).plot(KIND)",
    "replay": "load(NAME).replay(GENERATION)",
    "resume": "load(NAME).resume()",
    "run": "evolve(PRESET) to evolve, gaitsim.load(NAME) to open a run",
    "to_pandas": "load(NAME).to_pandas()",
    "video": "load(NAME).video(PATH)",
}


def __getattr__(name: str) -> object:
    if name not in __all__:
        from gaitsim.errors import nearest

        if not name.startswith("_"):
            from gaitsim.registry import FUNCTIONS, entries, find
            from gaitsim.registry.entry_points import install_hint
            from gaitsim.registry.loading import load_object

            if name in entries(FUNCTIONS):
                return load_object(find(FUNCTIONS, name))
            if package := install_hint(FUNCTIONS, name):
                raise AttributeError(f"gaitsim.{name} is not installed: {package}")

        close = nearest(name, __all__)
        hint = f"use gaitsim.{_GUESSED[name]}" if name in _GUESSED else close
        text = f"module 'gaitsim' has no attribute {name!r}"
        raise AttributeError(f"{text}: {hint}" if hint else text)
    return _load(name)


def __dir__() -> list[str]:
    from gaitsim.registry import FUNCTIONS, entries

    return [*__all__, *entries(FUNCTIONS), "__doc__", "__file__", "__name__", "__path__"]
