"""The directory of shared memory's files."""

import fcntl
from pathlib import Path

import pytest
import regatta
from regatta._domain import iceoryx2_config


@pytest.fixture(autouse=True)
def fresh_cache() -> object:
    iceoryx2_config.cache_clear()
    yield
    iceoryx2_config.cache_clear()


def test_a_directory_that_was_named_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_RUNTIME_DIR", str(tmp_path / "own"))
    config = iceoryx2_config()
    status = (tmp_path / "own").stat()
    assert f"regatta_{status.st_dev:x}-{status.st_ino:x}_" in str(config.global_cfg.prefix)
    assert str(tmp_path / "own") in str(config.global_cfg.root_path)


def test_a_directory_that_cannot_be_used_is_an_error_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("REGATTA_RUNTIME_DIR", str(tmp_path / "file"))
    with pytest.raises(regatta.OpenError, match="set REGATTA_RUNTIME_DIR") as caught:
        regatta.join("nobody")
    assert "\n" not in str(caught.value)


def test_the_directory_of_another_user_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_RUNTIME_DIR", str(tmp_path))
    owner = tmp_path.stat().st_uid
    monkeypatch.setattr("os.getuid", lambda: owner + 1)
    with pytest.raises(regatta.OpenError, match=f"it belongs to user {owner}"):
        iceoryx2_config()


def test_processes_that_see_another_shared_memory_are_not_joined(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("REGATTA_RUNTIME_DIR", str(tmp_path))
    with (tmp_path / "shared_memory").open("w") as theirs:
        theirs.write("a container")
        theirs.flush()
        fcntl.flock(theirs, fcntl.LOCK_SH)
        with pytest.raises(regatta.OpenError, match="another /dev/shm"):
            iceoryx2_config()
    # They have gone.
    iceoryx2_config()
    assert (tmp_path / "shared_memory").read_text() != "a container"
