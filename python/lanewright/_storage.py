"""Places on any file system that fsspec reaches: the local disk, HDFS, object stores."""

import os
import pathlib
import uuid
from typing import Any, Dict, Iterable, List, Optional, Union

import fsspec  # type: ignore[import-untyped]
from fsspec.implementations.local import LocalFileSystem  # type: ignore[import-untyped]


class Place:
    """A file or directory on some file system. It can be sent to another process, which opens the file system anew."""

    def __init__(self, path: Union[str, "os.PathLike[str]"], options: Optional[Dict[str, Any]] = None):
        self.options = options or {}
        self.fs, self.path = fsspec.core.url_to_fs(os.fspath(path), **self.options)

    def __reduce__(self):
        return Place, (str(self), self.options)

    def __str__(self) -> str:
        """The place as a URL, on the local disk as a path."""
        return self.path if self.local else self.fs.unstrip_protocol(self.path)

    def __truediv__(self, name: str) -> "Place":
        inner = object.__new__(Place)
        inner.options, inner.fs = self.options, self.fs
        inner.path = f"{self.path.rstrip('/')}/{name}"
        return inner

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rstrip("/").rsplit("/", 1)[-1]

    @property
    def local(self) -> bool:
        """Whether it lies on a disk of this machine, or one that is mounted."""
        return isinstance(self.fs, LocalFileSystem)

    def exists(self) -> bool:
        return self.fs.exists(self.path)

    def is_directory(self) -> bool:
        return self.fs.isdir(self.path)

    def state(self) -> List[List[str]]:
        """What tells whether a file, or one in a directory, was changed: name, size, and times or tags, as far as there are some."""
        keys = ("mtime", "LastModified", "last_modified", "updated", "modificationTime", "ETag", "etag")
        state = []
        for file, about in sorted(self.fs.find(self.path, detail=True).items()):
            known = (about.get(key) for key in keys)
            state.append([file, str(about.get("size")), *(str(value) for value in known if value is not None)])
        return state

    def read(self) -> bytes:
        return self.fs.cat_file(self.path)

    def make(self) -> None:
        """Makes a directory, with those above it. Object stores have none."""
        self.fs.makedirs(self.path, exist_ok=True)

    def remove(self) -> None:
        """Removes a file, or a directory with all that is in it; nothing if it is not there."""
        try:
            self.fs.rm(self.path, recursive=True)
        except FileNotFoundError:
            pass

    def write(self, content: bytes) -> None:
        """Writes a file under another name and moves it into its place, so that nobody sees half of it."""
        draft = self._beside()
        self.fs.pipe_file(draft.path, content)
        draft.move(self)

    def _beside(self) -> "Place":
        parent = object.__new__(Place)
        parent.options, parent.fs, parent.path = self.options, self.fs, self.fs._parent(self.path)
        return parent / f".{self.name}.{uuid.uuid4().hex}"

    def move(self, to: "Place") -> None:
        """Moves a file on its file system to another place, and takes that of a file that is there."""
        try:
            self.fs.mv(self.path, to.path)
        except OSError:
            # HDFS does not move a file over another.
            if not (self.exists() and to.exists()):
                raise
            to.remove()
            self.fs.mv(self.path, to.path)

    def fetch(self, directory: "Union[str, pathlib.Path]") -> pathlib.Path:
        """The file or directory on the local disk: where it is, or a copy in a directory that is there."""
        if self.local:
            return pathlib.Path(self.path)
        copy = pathlib.Path(directory, self.name)
        if self.is_directory():
            copy.mkdir()
            for found, about in self.fs.find(self.path, detail=True).items():
                if about["type"] == "file":
                    to = copy / found[len(self.path.rstrip("/")) + 1 :]
                    to.parent.mkdir(parents=True, exist_ok=True)
                    self.fs.get_file(found, str(to))
        else:
            self.fs.get_file(self.path, str(copy))
        return copy

    def put(self, files: Iterable[pathlib.Path]) -> None:
        """Copies local files into a directory."""
        for file in files:
            self.fs.put_file(str(file), (self / file.name).path)
