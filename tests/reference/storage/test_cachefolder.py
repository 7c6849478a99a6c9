"""A cache folder returns the contents that this user stored, and is refused if another user could write to it."""

import errno
import hashlib
import hmac
import os
import random
import stat
import subprocess
import sys
import warnings

import pytest
from gnomon.reference.storage import cachefolder


@pytest.fixture
def folder(tmp_path):
    """A folder with one file, whose parents the cache made."""
    found = tmp_path / "home" / "gnomon" / "results"
    cachefolder.store(found, "name", b"content")
    return found


def test_stored_content_is_loaded_until_it_is_replaced(folder):
    assert cachefolder.load(folder, "name") == b"content"
    assert cachefolder.load(folder, "another") is None
    cachefolder.store(folder, "name", b"")
    assert cachefolder.load(folder, "name") == b""
    assert sorted(path.name for path in folder.iterdir()) == ["key", "name"]


def test_no_other_user_can_read_or_write_whatever_the_umask(tmp_path):
    before = os.umask(0)
    try:
        folder = tmp_path / "home" / "gnomon" / "results"
        cachefolder.store(folder, "name", b"content")
    finally:
        os.umask(before)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in (*tmp_path.rglob("*"),)}
    assert modes == {"home": 0o700, "gnomon": 0o700, "results": 0o700, "name": 0o600, "key": 0o600}


@pytest.mark.parametrize("mode", [0o770, 0o720, 0o702, 0o777, 0o1777])
@pytest.mark.parametrize("level", ["results", "gnomon"])
def test_a_folder_that_others_can_write_is_refused_in_one_line(folder, level, mode):
    """If other users can write the parent folder, they can exchange this one."""
    unsafe = folder if level == "results" else folder.parent
    unsafe.chmod(mode)
    for access in (lambda: cachefolder.load(folder, "name"), lambda: cachefolder.store(folder, "b", b"")):
        with pytest.raises(ValueError, match=rf"{level} can be written by other users \(mode {mode:04o}\)") as refusal:
            access()
        assert "\n" not in str(refusal.value)
        assert "XDG_CACHE_HOME" in str(refusal.value)
    assert not (folder / "b").exists()


def test_a_folder_that_others_may_read_is_accepted(folder):
    """Earlier versions made it so, under the usual umask."""
    folder.chmod(0o755)
    assert cachefolder.load(folder, "name") == b"content"


@pytest.mark.parametrize("level", ["results", "gnomon"])
def test_a_folder_of_another_user_is_refused(folder, monkeypatch, level):
    path = folder if level == "results" else folder.parent
    found = os.lstat(path)
    others = os.stat_result((*found[:4], found.st_uid + 1, *found[5:10]))
    real = os.lstat
    monkeypatch.setattr(os, "lstat", lambda one: others if one == path else real(one))
    with pytest.raises(ValueError, match=f"{level} belongs to another user"):
        cachefolder.load(folder, "name")


def test_a_folder_that_is_exchanged_after_the_first_test_is_refused(folder, monkeypatch):
    """The owner of the open folder counts, not the owner of the folder that had its name before."""
    real = os.fstat
    others = os.stat_result((*real(0)[:4], os.geteuid() + 1, *real(0)[5:10]))
    monkeypatch.setattr(os, "fstat", lambda _descriptor: others)
    with pytest.raises(ValueError, match="belongs to another user"):
        cachefolder.load(folder, "name")


@pytest.mark.parametrize("level", ["results", "gnomon"])
def test_a_symbolic_link_is_refused(folder, tmp_path, level):
    path = folder if level == "results" else folder.parent
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match=f"{level} is a symbolic link"):
        cachefolder.load(folder, "name")


@pytest.mark.parametrize("kind", ["link", "pipe", "folder"])
def test_an_entry_that_is_no_regular_file_counts_as_absent(folder, tmp_path, kind):
    """Reading a pipe would not return."""
    path = folder / "name"
    content = path.read_bytes()
    path.unlink()
    if kind == "link":
        (tmp_path / "elsewhere").write_bytes(content)
        path.symlink_to(tmp_path / "elsewhere")
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()
    assert cachefolder.load(folder, "name") is None


def test_a_change_of_any_byte_makes_an_entry_absent(folder):
    cachefolder.store(folder, "name", bytes(range(256)) * 8)
    sound, rng = (folder / "name").read_bytes(), random.Random(17)
    for place in (*range(32), *(rng.randrange(len(sound)) for _ in range(300))):
        flipped = bytearray(sound)
        flipped[place] ^= 1 << rng.randrange(8)
        (folder / "name").write_bytes(flipped)
        assert cachefolder.load(folder, "name") is None, place
    (folder / "name").write_bytes(sound)
    assert cachefolder.load(folder, "name") == bytes(range(256)) * 8


def test_an_entry_without_the_key_of_its_folder_counts_as_absent(folder, tmp_path):
    """Made with a digest without key, with another key, for another name, or in another folder."""
    another = tmp_path / "another"
    cachefolder.store(another, "name", b"forged")
    cachefolder.store(folder, "a", b"forged")
    hashed = hashlib.sha256(b"name").digest()
    for content in (
        hashlib.sha256(b"forged").digest() + b"forged",
        hmac.digest(b"", hashed + b"forged", "sha256") + b"forged",
        hmac.digest(bytes(32), hashed + b"forged", "sha256") + b"forged",
        (another / "name").read_bytes(),
        (folder / "a").read_bytes(),
    ):
        (folder / "name").write_bytes(content)
        assert cachefolder.load(folder, "name") is None


@pytest.mark.parametrize("key", [None, b"", bytes(31), bytes(32), bytes(33)])
def test_without_its_key_a_folder_loses_its_entries_and_can_be_used_again(folder, key):
    (folder / "key").unlink()
    if key is not None:
        (folder / "key").write_bytes(key)
    assert cachefolder.load(folder, "name") is None
    cachefolder.store(folder, "name", b"content")
    assert cachefolder.load(folder, "name") == b"content"


def full(*_arguments, **_named):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_is_warned_of_once_and_leaves_no_partial_file(folder, monkeypatch, recwarn):
    monkeypatch.setattr(os, "replace", full)
    for name in "abc":
        cachefolder.store_or_warn(folder, name, b"content")
    cachefolder.prepare(folder)
    (warning,) = recwarn
    assert "results cannot be written (No space left on device)" in str(warning.message)
    assert sorted(path.name for path in folder.iterdir()) == ["key", "name"]


def test_child_processes_do_not_warn(tmp_path):
    """A run has thousands of them; their parent warns once."""
    (tmp_path / "file").write_text("where the folder should be")
    program = (
        "import multiprocessing, pathlib, sys\n"
        "from gnomon.reference.storage import cachefolder\n"
        "folder = pathlib.Path(sys.argv[1])\n"
        "cachefolder.prepare(folder)\n"
        "for _ in range(3):\n"
        "    child = multiprocessing.get_context('fork').Process(\n"
        "        target=cachefolder.store_or_warn, args=(folder / 'below', 'name', b''))\n"
        "    child.start()\n"
        "    child.join()\n"
    )
    run = subprocess.run([sys.executable, "-c", program, tmp_path / "file"], capture_output=True, text=True)
    assert run.returncode == 0
    assert run.stderr.count("cannot be written") == 1


def test_preparing_a_folder_leaves_no_file(folder):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cachefolder.prepare(folder)
    assert sorted(path.name for path in folder.iterdir()) == ["key", "name"]


def test_a_file_is_refused_by_its_size_before_it_is_read(folder):
    """Nobody has the memory for this one. It takes no space on disk, as it has no content."""
    os.truncate(folder / "name", 2**42)
    assert cachefolder.load(folder, "name") is None
    cachefolder.store(folder, "name", b"content")
    assert cachefolder.load(folder, "name") == b"content"


def test_what_would_not_be_read_is_not_written(folder, monkeypatch):
    cachefolder.store(folder, "long", bytes(100))
    monkeypatch.setattr(cachefolder, "MOST_BYTES", 100)
    assert cachefolder.load(folder, "long") is None
    cachefolder.store(folder, "longer", bytes(100))
    assert not (folder / "longer").exists()
    cachefolder.store(folder, "short", bytes(50))
    assert cachefolder.load(folder, "short") == bytes(50)
