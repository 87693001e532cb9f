"""Signatures of runs with an SSH key, made and verified by OpenSSH's `ssh-keygen -Y`.

A signature covers a short text: a generation, the head of the chain of checksums there, and a hash
of the options of all generations up to it. It therefore covers every generation up to that one,
and remains valid when the run continues.
"""

import hashlib
import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gaitsim.errors import GaitsimError, RunError
from gaitsim.opening import read_regular
from gaitsim.storage.consistency import checksum
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import SIGNATURE, SIGNED
from gaitsim.storage.snapshot import RunSnapshot

NAMESPACE = "gaitsim"  # so that the signature of something else is not accepted
LARGEST = 20_000  # bytes of a signature
PATIENCE = 20.0  # seconds to verify


@dataclass(frozen=True)
class Signature:
    """A signature of a run.

    Attributes:
        generation: last generation that it covers; 0 if it is invalid.
        signer: key of the signer, and the name that a list of signers gives to it.
        known: whether a list of signers has the key.
        problem: why it is invalid; '' if it is valid.
    """

    generation: int
    signer: str
    known: bool = False
    problem: str = ""


def sign(run: RunSnapshot, key: Path) -> None:
    """Sign a run up to its last generation; `ssh-keygen` may ask for the passphrase of the key."""
    text = _statement(run, run.finished.generation)
    if not key.is_file():
        raise GaitsimError(
            f"there is no key {key}",
            where="--sign",
            allowed="the file of a private SSH key, or of a public one whose private key an agent "
            "holds",
            remedy="make one: ssh-keygen -t ed25519 -f my-key",
        )
    done = _ssh_keygen("sign", "-f", str(key), text=text, patience=None)
    if done.returncode:
        reason = done.stderr.decode(errors="replace").strip().splitlines() or ["it gave no reason"]
        raise GaitsimError(f"ssh-keygen cannot sign with {key}: {reason[-1]}", where="--sign")
    write_bytes(run.path / SIGNED, text.encode(), follow=False)
    write_bytes(run.path / SIGNATURE, done.stdout, follow=False)


def read_signature(run: RunSnapshot, signers: Path | None = None) -> Signature | None:
    """Verify the signature of a run; return None without one.

    Args:
        run: the run.
        signers: list of keys and their owners, in the format of `ALLOWED SIGNERS` of ssh-keygen(1).
    """
    try:
        signature = read_regular(run.path / SIGNATURE, LARGEST)
        text = read_regular(run.path / SIGNED, LARGEST).decode()
    except FileNotFoundError as error:
        if not (run.path / SIGNED).exists() and not (run.path / SIGNATURE).exists():
            return None
        return Signature(0, "", problem=f"{Path(error.filename).name} is missing")
    except (OSError, UnicodeDecodeError) as error:
        raise RunError(
            f"cannot read the signature of {run.path}: {error}",
            remedy=f"delete {SIGNED} and {SIGNATURE}",
        ) from None
    with TemporaryDirectory() as folder:
        copy = Path(folder, "signature")  # the file in the run may be replaced meanwhile
        copy.write_bytes(signature)
        place = ("-s", str(copy))
        done = _ssh_keygen("check-novalidate", *place, text=text)
        if done.returncode:
            return Signature(0, "", problem=f"it does not fit {SIGNED}")
        signer, known = _signer(done.stdout), False
        if signers is not None:
            listed = ("-f", str(signers))
            names = _ssh_keygen("find-principals", *place, *listed, text="").stdout.decode().split()
            for name in names[:1]:
                done = _ssh_keygen("verify", *place, *listed, "-I", name, text=text)
                known = done.returncode == 0
                signer = f"{name}, {signer}" if known else signer
    generation = _generation(text)
    if not 1 <= generation <= run.generation:
        return Signature(0, signer, known, f"it is for generation {generation} of a longer run")
    if text != _statement(run, generation):
        return Signature(0, signer, known, f"it is for other results up to generation {generation}")
    return Signature(generation, signer, known)


def _statement(run: RunSnapshot, generation: int) -> str:
    """Return the text that a signature covers."""
    head = checksum(run, generation, "chain")
    if head is None:
        raise RunError(
            f"generation {generation} of {run.path} has no checksum",
            remedy="verify the run without --sign",
        )
    options = hashlib.sha256()
    for stage in run.stages:
        if stage.first <= generation:
            options.update(f"{stage.first} {stage.outline.search_options()}\n".encode())
    return (
        f"gaitsim run\ngeneration: {generation}\nchain: {head.hex()}\n"
        f"options: {options.hexdigest()}\n"
    )


def _generation(text: str) -> int:
    """Return the generation in a statement; 0 if there is none."""
    found = [line.partition(": ")[2] for line in text.splitlines() if line.startswith("generation")]
    return int(found[0]) if found and found[0].isascii() and found[0].isdecimal() else 0


def _signer(message: bytes) -> str:
    """Return the key in the message 'Good "gaitsim" signature with ED25519 key SHA256:…'."""
    return message.decode(errors="replace").strip().rpartition(" with ")[2]


def _ssh_keygen(
    verb: str, *arguments: str, text: str, patience: float | None = PATIENCE
) -> subprocess.CompletedProcess[bytes]:
    line = ["ssh-keygen", "-Y", verb, "-n", NAMESPACE, *arguments]
    try:
        return subprocess.run(
            line, input=text.encode(), capture_output=True, timeout=patience, check=False
        )
    except FileNotFoundError:
        raise GaitsimError(
            "the program ssh-keygen is missing, which makes and verifies signatures",
            remedy="install OpenSSH, such as the package openssh-client, version 8.2 or newer",
        ) from None
    except subprocess.TimeoutExpired:
        raise GaitsimError(f"ssh-keygen did not answer within {patience:g} s") from None
