"""Reads text files that somebody else may have made: only regular files, of a limited size."""

from pathlib import Path

MOST_BYTES = 1 << 24


def read_text(path: Path, most: int = MOST_BYTES) -> str:
    """The text of a regular file of at most `most` bytes: a pipe or a device may give text without end, or none.

    Raises ValueError, which names the file, for anything else, and for text that is not UTF-8.
    """
    if not path.is_file():
        obstacle = "a folder, a pipe or a device" if path.exists() else "no such file"
        raise ValueError(f"{path}: {obstacle}; give a text file")
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{path}: more than {most} bytes; give a file of at most these")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not a text file: {error.reason}") from None
