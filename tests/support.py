"""A clone of the repository, for tests of the whole house."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MADE_BY_NO_STAGE = ("reports/paper/", "reports/searches/README", "reports/ablations/README")


@dataclass(frozen=True)
class Clone:
    """A repository of its own, made of the working tree; it shares no cache and no artefact with it."""

    root: Path

    def begin(self) -> None:
        """Makes a repository of the files at ``root``, runs its stages and commits the results."""
        self.run("git", "init", "--quiet", "--initial-branch", "main")
        self.run("dvc", "init", "--quiet")
        self.run("dvc", "repro", "--quiet")
        self.commit("its results")

    def run(
        self, *command: str | Path, timeout_s: float = 300, status: int | None = 0, **environment: str
    ) -> subprocess.CompletedProcess[str]:
        """Runs a command in the clone, in the environment that runs the tests.

        Args:
            command: the program and its arguments; ``python`` and ``dvc`` are the environment's.
            timeout_s: after so long the test fails.
            status: the exit status that must come out; None takes any.
            environment: variables set besides.
        """
        done = subprocess.run(
            [str(part) for part in command],
            cwd=self.root,
            env=self._environment() | environment,
            capture_output=True,
            text=True,
            timeout=timeout_s,
        )
        if status is not None and done.returncode != status:
            pytest.fail(
                f"{command} ended with {done.returncode}:\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
            )
        return done

    def _environment(self) -> dict[str, str]:
        beside = self.root.parent / "beside the clone"
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("GIT_", "DVC_", "BELVEDERE_"))}
        return kept | {
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
            "DVC_SITE_CACHE_DIR": str(beside),
            "DVC_NO_ANALYTICS": "1",
            "GIT_CONFIG_GLOBAL": os.devnull,
            "GIT_AUTHOR_NAME": "A Test",
            "GIT_AUTHOR_EMAIL": "test@localhost",
            "GIT_COMMITTER_NAME": "A Test",
            "GIT_COMMITTER_EMAIL": "test@localhost",
        }

    def commit(self, message: str) -> None:
        """Commits all that git does not ignore."""
        self.run("git", "add", "--all")
        self.run("git", "commit", "--quiet", "--allow-empty", "--message", message)

    def lend_environment(self) -> None:
        """Gives the clone the environment that runs the tests, as if its own ./run had made it."""
        venv = self.root / ".venv"
        venv.mkdir()
        for entry in Path(sys.prefix).iterdir():
            if entry.name != "stamp":
                (venv / entry.name).symlink_to(entry)
        lock = (self.root / "requirements.lock").read_text(encoding="utf-8")
        (venv / "stamp").write_text(f"# {self.root}\n{lock}", encoding="utf-8")


def clone_repository(root: Path) -> Clone:
    """Copies the files that git knows or would take to ``root``, as a repository with one commit.

    The committed results stay behind: a test makes its own.
    """
    for name in _files():
        result = name.startswith("reports/") and not name.startswith(MADE_BY_NO_STAGE)
        if name == "dvc.lock" or (result and not name.endswith(".gitignore")):
            continue
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, root / name)
    made = Clone(root)
    made.run("git", "init", "--quiet", "--initial-branch", "main")
    made.commit("as it is")
    return made


def _files() -> list[str]:
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return [name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


def ran(log: str) -> set[str]:
    """The stages that DVC says it ran."""
    return set(re.findall(r"Running stage '([^']+)'", log))
