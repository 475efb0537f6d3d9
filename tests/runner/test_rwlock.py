"""A process that was killed while DVC wrote its list of locks does not end later runs."""

from __future__ import annotations

import pytest

from tests.support import Clone


@pytest.mark.parametrize("left", ["", '{"read": {"a'])
def test_what_a_kill_left_of_the_list_of_locks_is_dropped(clone: Clone, left: str) -> None:
    path = clone.root / ".dvc/tmp/rwlock"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(left, encoding="utf-8")
    assert "corrupted" in clone.run("dvc", "repro", "--dry", "rollouts@panda_1dof", status=None).stderr
    clone.run("python", "-m", "runner.dvc", "repro", "--dry", "rollouts@panda_1dof")
    path.write_text(left, encoding="utf-8")
    code = (
        "from runner.plan import read_pipeline; from runner.rwlock import drop_damaged_rwlock\n"
        "drop_damaged_rwlock(); print(*read_pipeline(['rollouts@panda_1dof']).waits)"
    )
    assert clone.run("python", "-c", code).stdout.split() == ["scene@panda_1dof", "rollouts@panda_1dof"]
