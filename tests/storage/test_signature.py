"""Signatures by SSH keys, made and verified by ssh-keygen."""

import shutil
import subprocess

import pytest
from run_helpers import evolve_run

from gaitsim.errors import GaitsimError
from gaitsim.storage.creation import create_run
from gaitsim.storage.signature import read_signature, sign
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import verify

pytestmark = pytest.mark.skipif(shutil.which("ssh-keygen") is None, reason="needs OpenSSH")


@pytest.fixture
def key(tmp_path):
    """A function that makes a private key."""

    def make(name="key"):
        path = tmp_path / name
        line = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", name, "-f", str(path)]
        subprocess.run(line, check=True)
        return path

    return make


@pytest.fixture
def signed(puppet, tmp_path, key):
    run = evolve_run(create_run(puppet("evolution.generations=4"), tmp_path / "run"))
    sign(run, key())
    return RunSnapshot(run.path)


def again(run):
    return read_signature(RunSnapshot(run.path))


def test_a_signed_run_is_valid_and_remains_so_when_it_continues(signed):
    found = again(signed)
    assert (found.generation, found.problem, found.known) == (4, "", False)
    assert found.signer.startswith("ED25519 key SHA256:")
    evolve_run(signed.path, generations=6)
    verdict = verify(RunSnapshot(signed.path), workers=1)
    assert verdict.identical
    assert verdict.signature.generation == 4


def test_ssh_keygen_itself_accepts_the_files(signed):
    line = ["ssh-keygen", "-Y", "check-novalidate", "-n", "gaitsim"]
    line += ["-s", str(signed.path / "signed.txt.sig")]
    with (signed.path / "signed.txt").open("rb") as text:
        assert subprocess.run(line, stdin=text, check=False).returncode == 0


def test_a_list_of_signers_names_the_signer(signed, tmp_path, key):
    public = (tmp_path / "key.pub").read_text()
    signers = tmp_path / "signers.txt"
    signers.write_text(f"ann@example.org {public}")
    found = read_signature(signed, signers)
    assert found.known
    assert found.signer.startswith("ann@example.org, ED25519 key SHA256:")
    signers.write_text(f"ben@example.org {key('other').with_suffix('.pub').read_text()}")
    found = read_signature(signed, signers)
    assert (found.known, found.problem) == (False, "")


def test_other_results_are_not_signed(signed, puppet, tmp_path):
    other = evolve_run(create_run(puppet("evolution.generations=4", "seed=2"), tmp_path / "other"))
    shorter = evolve_run(create_run(puppet("evolution.generations=3"), tmp_path / "shorter"))
    for run, problem in ((other, "for other results"), (shorter, "of a longer run")):
        for name in ("signed.txt", "signed.txt.sig"):
            shutil.copy(signed.path / name, run.path / name)
        assert problem in again(run).problem
        assert not verify(RunSnapshot(run.path), workers=1).identical


@pytest.mark.parametrize("name", ["signed.txt", "signed.txt.sig"])
def test_a_changed_or_missing_file_is_invalid(signed, name):
    path = signed.path / name
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert again(signed).problem
    path.unlink()
    assert again(signed).problem == f"{name} is missing"


def test_a_signature_for_another_purpose_is_invalid(signed, tmp_path):
    path = signed.path / "signed.txt.sig"
    line = ["ssh-keygen", "-Y", "sign", "-n", "file", "-f", str(tmp_path / "key")]
    text = (signed.path / "signed.txt").read_bytes()
    path.write_bytes(subprocess.run(line, input=text, capture_output=True, check=True).stdout)
    assert again(signed).problem


def test_a_missing_key_or_program_is_a_user_error(signed, tmp_path, monkeypatch):
    with pytest.raises(GaitsimError, match="there is no key"):
        sign(signed, tmp_path / "nothing")
    (tmp_path / "text").write_text("no key")
    with pytest.raises(GaitsimError, match="ssh-keygen cannot sign"):
        sign(signed, tmp_path / "text")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(GaitsimError, match="ssh-keygen is missing"):
        sign(signed, tmp_path / "key")
