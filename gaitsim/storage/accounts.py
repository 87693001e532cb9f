"""Results of verifying files: what was compared, and what cannot be known."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from gaitsim.repr_mixin import ReprField, ReprMixin


class Account(NamedTuple):
    """The comparisons of a file.

    Attributes:
        file: name of the file or folder.
        compared: parts that were compared or reproduced.
        unknown: parts that nothing in the folder can prove; '' if there are none.
    """

    file: str
    compared: str
    unknown: str = ""


@dataclass(frozen=True, repr=False)
class FilesVerdict(ReprMixin):
    """The result of verifying a study, a comparison or an adaptation.

    Attributes:
        kind: 'study', 'comparison', 'adaptation' or 'adaptation report'.
        parts: the parts that can be repeated, and how, such as 'cells run'.
        total: number of these parts.
        again: numbers of the parts that were repeated.
        complete: whether everything was repeated, so that nothing can be forged.
        differences: one message for each difference; () if all is identical.
        accounts: comparisons of each file.
        notes: further limits of the verification, one sentence each.
    """

    kind: str
    parts: str
    total: int
    again: tuple[int, ...]
    complete: bool
    differences: tuple[str, ...]
    accounts: tuple[Account, ...]
    notes: tuple[str, ...] = ()

    @property
    def identical(self) -> bool:
        """Whether everything that was compared is identical."""
        return not self.differences

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "kind": self.kind,
            "identical": self.identical,
            "complete": self.complete,
            "again": len(self.again),
            "different": "; ".join(self.differences[:1]),
        }
