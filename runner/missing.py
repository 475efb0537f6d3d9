"""`--allow-missing` in a clone that has results but no data: what a stage reads is made before it runs.

With --allow-missing DVC passes over stages whose outputs are absent, if they would come out as dvc.lock has
them. A stage behind them that did change was then started all the same, after its former outputs had been
deleted, and found no input. Here the stages that make its input run first, as without --allow-missing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


def make_missing() -> None:
    """Makes DVC, in this process, reproduce what a stage that runs reads and what is absent."""
    from dvc.repo import reproduce

    plain = reproduce._reproduce

    def with_inputs(
        stages: list[Any],
        graph: Any = None,
        repro_fn: Callable[..., Any] = reproduce._reproduce_stage,
        **how: Any,
    ) -> list[Any]:
        return plain(stages, graph=graph, repro_fn=_WithInputs(graph, repro_fn), **how)

    reproduce._reproduce = with_inputs


def refuse_missing_in_queue() -> None:
    """Makes DVC, in this process, refuse to queue experiments with --allow-missing.

    Queued experiments run in copies of the repository, by a `dvc` that :func:`make_missing` does not reach.
    """
    from dvc.exceptions import InvalidArgumentError
    from dvc.repo.experiments import run

    plain = run.run

    def run_or_refuse(repo: Any, *words: Any, queue: bool = False, **how: Any) -> Any:
        if queue and how.get("allow_missing"):
            raise InvalidArgumentError(
                "--allow-missing does not go with --queue, whose experiments run in copies of the repository "
                "that lack the same data; leave it out and name a target, such as evaluation@study: what the "
                "target needs is then made."
            )
        return plain(repo, *words, queue=queue, **how)

    run.run = run_or_refuse


@dataclass(frozen=True)
class _WithInputs:
    """Reproduces a stage as DVC does, and before it what it needs and lacks.

    Attributes:
        graph: DVC's, of stages and those they wait for; ``None`` where no other stage may run.
        reproduce: DVC's function.
        made: the stages that were made for others.
    """

    graph: Any
    reproduce: Callable[..., Any]
    made: set[Any] = field(default_factory=set)

    def __call__(
        self, stage: Any, allow_missing: bool = False, force: bool = False, dry: bool = False, **how: Any
    ) -> Any:
        how |= {"allow_missing": allow_missing, "dry": dry}
        if (allow_missing or dry) and (force or stage.changed(allow_missing, how.get("upstream"))):
            if allow_missing:
                self._make_inputs(stage, how)
            # or DVC looks for the stage in its run cache by inputs that a dry run leaves absent
            force = force or (dry and bool(_absent(stage)))
        return self.reproduce(stage, force=force, **how)

    def _make_inputs(self, stage: Any, how: dict[str, Any]) -> None:
        """Reproduces the stages behind the absent inputs of ``stage``, the first of them first."""
        absent = _absent(stage)
        for maker in stage.repo.index.graph.successors(stage):
            if maker in self.made or absent.isdisjoint(out.fs_path for out in maker.outs):
                continue
            if self.graph is None:
                raise _alone(stage, maker)
            self.made.add(maker)
            self._make_inputs(maker, how)
            self(maker, **(how | {"upstream": list(self.graph.successors(maker)), "allow_missing": False}))


def _absent(stage: Any) -> set[str]:
    """The paths that a stage reads and that are not there."""
    return {dep.fs_path for dep in stage.deps if not dep.exists}


def _alone(stage: Any, maker: Any) -> Exception:
    from dvc.exceptions import DvcException

    return DvcException(
        f"stage '{stage.addressing}' needs what '{maker.addressing}' makes, which is absent here; leave "
        f"--single-item out, or run `dvc repro {maker.addressing}` before."
    )
