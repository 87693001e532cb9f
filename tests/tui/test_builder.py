"""Experiments under construction, and the equivalent commands."""

import shlex
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from pydantic import create_model

from gaitsim.contracts import option
from gaitsim.experiment import load_experiment, parse_assignments
from gaitsim.registry import options
from gaitsim.tui.builder import ExperimentBuilder, choose_plugin, load_preset, validate
from gaitsim.tui.catalogue import read_catalogue

SPIDER = load_preset("spider-genetic")


@pytest.fixture(scope="module")
def catalogue():
    return read_catalogue()


def build(**changes):
    changed = {key.replace("__", "."): text for key, text in changes.items()}
    return ExperimentBuilder(SPIDER, changed)


class TestCommand:
    def test_unchanged_options_are_omitted(self):
        assert build().command(Path("runs/spider")) == "gaitsim run spider-genetic"

    def test_another_folder_is_included(self):
        command = build().command(Path("elsewhere/spider"))
        assert command == "gaitsim run spider-genetic --out elsewhere/spider"

    def test_the_command_creates_the_same_experiment(self, catalogue):
        builder = build(
            seed="12", name="odd name", evolution__population="40", organism__encoding="cpg"
        )
        words = shlex.split(builder.command(Path("runs/odd name")))
        overrides = words[words.index("--set") :][1::2]
        found = validate(builder, catalogue)
        assert found.experiment == load_experiment(words[2], parse_assignments(overrides))
        assert found.toml == load_experiment("spider-genetic", builder.overrides).to_toml()
        assert (found.experiment.seed, found.name) == (12, "odd name")

    def test_undoing_a_change_restores_the_preset(self):
        builder = build().assign("seed", "3").assign("seed", None)
        assert builder == build()


class TestValidate:
    def test_each_problem_has_the_key_of_its_option(self, catalogue):
        found = validate(build(evolution__population="x", mutation__rate="7", seed="-1"), catalogue)
        assert set(found.problems) == {"evolution.population", "mutation.rate", "seed"}
        assert found.experiment is None
        assert found.toml == ""

    def test_words_of_a_path_are_not_mistaken_for_keys(self, catalogue, tmp_path):
        file = tmp_path / "key west" / "section x.toml"
        file.parent.mkdir()
        file.write_text(SPIDER.text)
        builder = ExperimentBuilder(replace(SPIDER, reference=str(file)), {"mutation.rate": "7"})
        assert set(validate(builder, catalogue).problems) == {"mutation.rate"}
        broken = replace(SPIDER, reference=str(file), text=SPIDER.text.replace("elites", "elite"))
        assert set(validate(ExperimentBuilder(broken), catalogue).problems) == {"search.elite"}

    @pytest.mark.slow
    def test_a_robot_is_read_again_when_its_scale_changes(self, catalogue, tmp_path):
        model = files("gaitsim_robot") / "models" / "quadruped.xml"
        file = tmp_path / "robot.xml"
        file.write_bytes(model.read_bytes())
        loaded = load_preset(str(file))
        found = validate(ExperimentBuilder(loaded, {"organism.scale": "0.5"}), catalogue)
        assert found.experiment.organism.anatomy.trunk == pytest.approx(0.14)
        assert not found.warnings
        large = validate(ExperimentBuilder(loaded, {"organism.scale": "1000"}), catalogue)
        assert "\n⚠ the robot is 280 m long" in large.summary

    def test_guesses_about_a_file_are_shown_until_an_option_answers_them(self, shaped, tmp_path):
        (tmp_path / "a.shape").write_text("<a/>")
        loaded = load_preset(str(tmp_path / "a.shape"))
        found = validate(ExperimentBuilder(loaded), read_catalogue())
        assert found.summary.endswith("\n? Is it plain? (label)")
        answered = ExperimentBuilder(loaded, {"organism.label": "odd"})
        assert "?" not in validate(answered, read_catalogue()).summary
        assert "… and 2 more" in replace(found, questions=found.questions * 4).summary

    def test_a_problem_of_an_item_is_that_of_its_option(self, catalogue):
        worlds, cases = load_preset("walker-worlds"), "[{friction = 0.4}, {}]"
        found = validate(ExperimentBuilder(worlds, {"worlds.cases": cases}), catalogue)
        assert found.experiment.worlds.cases == ({"friction": 0.4}, {})
        wrong = {"worlds.cases": "[{}, {fog = 1}]", "worlds.ranges": "{friction = [1, 9]}"}
        found = validate(ExperimentBuilder(worlds, wrong), catalogue)
        assert set(found.problems) == {*wrong}
        assert found.problems["worlds.cases"].what == "unknown condition 'fog'"

    def test_forms_have_every_option_with_its_value(self, catalogue):
        found = validate(build(fitness__yaw_weight="9"), catalogue)
        texts = {option.key: option.text for option in found.forms["fitness"].options}
        assert texts["fitness.yaw_weight"] == "9"
        plugin = load_experiment("spider").fitness
        assert set(texts) == {f"fitness.{name}" for name in type(plugin).model_fields}
        for one in found.forms["fitness"].options:
            assert options.parse_value(one.preset) == getattr(plugin, one.key.split(".")[1])

    def test_texts_of_all_presets_survive_a_round_trip(self, catalogue):
        for preset in catalogue.presets:
            loaded = load_preset(preset.name)
            found = validate(ExperimentBuilder(loaded), catalogue)
            texts = {o.key: o.text for form in found.forms.values() for o in form.options if o.text}
            again = validate(ExperimentBuilder(loaded, texts), catalogue)
            assert again.experiment == found.experiment, preset.name


class TestOffers:
    def test_only_compatible_plugins_are_offered(self, catalogue):
        found = validate(build(), catalogue)
        assert set(found.offered["fitness"]) == {"spider-walk", "spider-classic"}
        assert "bit-flip" not in found.offered["mutation"]
        for kind in ("fitness", "selection", "crossover", "mutation"):
            for name in found.offered[kind]:
                other = validate(choose_plugin(found, kind, name, catalogue), catalogue)
                assert not {f"{kind}.plugin"} & set(other.problems), (kind, name)

    @pytest.mark.parametrize("preset", ["spider", "spider-genetic"])
    def test_every_body_is_completed_with_compatible_plugins(self, catalogue, preset):
        found = validate(ExperimentBuilder(load_preset(preset)), catalogue)
        for body in found.offered["organism"]:
            other = validate(choose_plugin(found, "organism", body, catalogue), catalogue)
            assert other.experiment is not None, (body, other.problems)
            assert other.forms["organism"].plugin == body

    def test_compatible_plugins_are_kept(self, catalogue):
        found = validate(build(mutation__plugin="reset"), catalogue)
        other = validate(choose_plugin(found, "organism", "fly", catalogue), catalogue)
        assert other.forms["mutation"].plugin == "reset"

    def test_another_plugin_drops_the_options_of_the_old_one(self, catalogue):
        found = validate(build(mutation__rate="0.5"), catalogue)
        builder = choose_plugin(found, "mutation", "reset", catalogue)
        assert dict(builder.changes) == {"mutation.plugin": "reset"}


texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=12)


@given(texts | st.none())
def test_any_text_survives_a_round_trip(value):
    model = create_model("Model", label=(str | None, option(None, "a text")))
    field = model.model_fields["label"]
    if value is not None and value.lower() == "none":
        return  # 'none' unsets an option, so it cannot be a text
    written = options.format_value(field, value)
    typed = parse_assignments([f"key={written}"])["key"]
    assert options.convert_value(field, options.parse_value(typed), typed) == value
