"""trials: joins all sessions of a study into one table, and says which attempts do not count."""

from __future__ import annotations

from pathlib import Path

from pipeline.contract import params
from pipeline.storage.artefacts import writing
from pipeline.storage.stage import entry
from pipeline.study.folder import read_study
from pipeline.study.params import ExcludeParams
from pipeline.study.trials import excluded_table, trials_table


def main(*, study: Path, out: Path, excluded: Path) -> None:
    """Reads a study's folder.

    Args:
        study: the folder; without participants the tables stay empty.
        out: Parquet, one row an ended attempt.
        excluded: CSV, the rows that do not count, each with its reasons.
    """
    table = trials_table(read_study(study), params.section(ExcludeParams, "people", "exclude"))
    left_out = excluded_table(table)
    with writing(out) as aside:
        table.write_parquet(aside)
    with writing(excluded) as aside:
        left_out.write_csv(aside)
    people = table["participant"].n_unique()
    print(f"{study}: {people} participant(s), {len(table)} ended attempts, {len(left_out)} of them left out")


if __name__ == "__main__":
    entry(main)
