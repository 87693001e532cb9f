"""The long description of the package: README.md without relative links and pictures."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_PICTURE = re.compile(r"!\[[^\]]*\]\((?!https?:)[^)\s]+\)\n*")
_LINK = re.compile(r"\[([^\]]+)\]\((?!https?:)[^)\s]+\)")


class Readme(MetadataHookInterface):
    """Build hook that sets `readme` in the metadata of the wheel and the sdist."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Remove pictures with relative paths, and replace relative links by their text.

        A package index would resolve both against its own site.
        """
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = _LINK.sub(r"\1", _PICTURE.sub("", text))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
