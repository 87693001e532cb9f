"""An experiment file with its sections, keys and comments in colours."""

from rich.text import Text


def coloured(toml: str, section: str, key: str) -> Text:
    """Return the text with its sections and keys in these colours, comments dim."""
    whole = Text(no_wrap=True)
    for line in toml.splitlines():
        text = Text(line)
        name, equals, value = line.partition(" = ")
        # A comment after a value. A value that holds ' # ' itself is dimmed too early, no more.
        comment = len(line) if line.startswith("#") else value.find(" # ")
        if line.startswith("["):
            text.stylize(f"bold {section}")
        elif equals and not line.startswith("#"):
            text.stylize(key, 0, len(name))
        if comment >= 0:
            text.stylize("dim", 0 if line.startswith("#") else len(name + equals) + comment)
        whole.append_text(text).append("\n")
    return whole
