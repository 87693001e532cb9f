"""The long description of the package: README.md without what works only beside its sources."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_PICTURE = re.compile(r"!\[[^\]]*\]\((?!https?:)[^)\s]+\)\n*")
_LINK = re.compile(r"\[([^\]]+)\]\((?!https?:)[^)\s]+\)")


class Readme(MetadataHookInterface):
    """Set `readme` when a wheel or an sdist is built."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Drop pictures with relative paths, and turn relative links into their words.

        A package index shows the text alone: it would look for both on its own site.
        """
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = _LINK.sub(r"\1", _PICTURE.sub("", text))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
