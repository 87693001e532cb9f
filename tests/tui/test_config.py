"""The settings: reading them, their problems, and storing a theme."""

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.tui.config import Config, check_keys, config_path, read_config, remember
from gaitsim.tui.themes import check_theme


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "config.toml"
        path.write_text(text)
        return read_config(path)

    return read


class TestPath:
    def test_the_folder_in_xdg_config_home_is_used(self, monkeypatch, tmp_path):
        monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
        assert config_path() == tmp_path / "gaitsim" / "config.toml"

    @pytest.mark.parametrize("value", ["", "relative"])
    def test_the_home_is_used_without_a_valid_variable(self, monkeypatch, tmp_path, value):
        monkeypatch.setenv("XDG_CONFIG_HOME", value)
        monkeypatch.setenv("HOME", str(tmp_path))
        assert config_path() == tmp_path / ".config" / "gaitsim" / "config.toml"


class TestRead:
    def test_a_missing_file_is_not_a_problem(self, tmp_path):
        assert read_config(tmp_path / "none.toml") == Config(tmp_path / "none.toml")

    def test_theme_and_keys(self, read):
        found = read(
            '[tui]\ntheme = "nord"\nnotify = false\n[keys]\nhome.delete = "x"\n'
            '"home.new" = "a, b"\n'
        )
        assert (found.theme, found.notify) == ("nord", False)
        assert found.keys == {"home.delete": "x", "home.new": "a, b"}
        assert not found.problems

    def test_unknown_sections_and_keys_are_reported_with_a_suggestion(self, read):
        found = read('[tiu]\n[tui]\nthem = "nord"\n')
        assert {problem.key: problem.remedy for problem in found.problems} == {
            "tiu": "did you mean 'tui'?",
            "tui.them": "did you mean 'theme'?",
        }

    @pytest.mark.parametrize(
        "text",
        [
            "[tui]\ntheme = 1",
            "[tui]\nnotify = 'no'",
            "[keys]\nhome.new = 1",
        ],
    )
    def test_a_value_of_the_wrong_type_is_reported(self, read, text):
        found = read(text)
        [problem] = found.problems
        assert problem.what.startswith(f"invalid {problem.key}: ")
        assert problem.key in ("tui", "keys", "tui.theme", "tui.notify", "keys.home.new", "keys.x")
        assert (found.theme, found.keys) == (None, {})

    def test_invalid_toml_is_reported(self, read):
        assert "not valid TOML" in read("[tui").problems[0].what


class TestCheck:
    def test_an_unknown_theme(self, read):
        assert check_theme("gaitsim-light", where="--theme") == "gaitsim-light"
        with pytest.raises(GaitsimError, match="gaitsim-lite") as caught:
            check_theme("gaitsim-lite", where="--theme")
        assert caught.value.remedy == "did you mean 'gaitsim-light'?"
        [problem] = read('[tui]\ntheme = "gaitsim-lite"').problems
        assert problem.key == "tui.theme"

    @pytest.mark.parametrize(
        "key", ["x", "X", "?", "ctrl+d", "f5", "enter", "ctrl+shift+left", "a,b", "plus"]
    )
    def test_known_keys_are_accepted(self, tmp_path, key):
        assert not check_keys(Config(tmp_path, keys={"home.new": key}))

    @pytest.mark.parametrize("key", ["ctl+d", "entr", "ctrl+", "f99", "a,,b", "ctrl+entr"])
    def test_unknown_keys_are_reported(self, tmp_path, key):
        found = check_keys(Config(tmp_path, keys={"home.new": key}))
        assert len(found) == 1
        assert "there is no key" in found[0].what

    def test_an_unknown_id(self, tmp_path):
        found = check_keys(Config(tmp_path, keys={"home.delte": "x"}))
        assert [problem.remedy for problem in found] == ["did you mean 'home.delete'?"]
        assert found[0].key == "keys.home.delte"


class TestRemember:
    def test_the_rest_of_the_file_is_kept(self, tmp_path):
        path = tmp_path / "deep" / "config.toml"
        remember(path, "theme", "nord")
        assert read_config(path).theme == "nord"
        path.write_text('# mine\n[keys]\nhome.new = "x" # so\n')
        remember(path, "theme", "dracula")
        text = path.read_text()
        assert text.startswith('# mine\n[keys]\nhome.new = "x" # so\n')
        found = read_config(path)
        assert (found.theme, found.keys) == ("dracula", {"home.new": "x"})
        remember(path, "preview", value=False)
        assert not read_config(path).preview

    @pytest.mark.parametrize("text", [b"tui = 3\n", b"\xff\xfe"])
    def test_unreadable_settings_are_not_overwritten(self, text, tmp_path):
        path = tmp_path / "config.toml"
        path.write_bytes(text)
        with pytest.raises(GaitsimError, match=r"'tui' must be a section|UTF-8"):
            remember(path, "theme", "nord")
        assert path.read_bytes() == text
