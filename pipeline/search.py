"""Says where a scene's search over the sphere stands: who is left, and where the camera should stand.

Set BELVEDERE_MIX=allow to compare candidates that were made on different devices or versions.
"""

from __future__ import annotations

from pathlib import Path

import polars as pl

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.stats import search_content
from pipeline.stats.halving import least_trainings
from pipeline.stats.params import HalvingParams, RankingParams
from pipeline.stats.race import Rules
from pipeline.stats.reading import mixture_allowed
from pipeline.stats.searched import Searched, read_searched, stand
from pipeline.stats.surface import grid, surface, unit_vectors
from pipeline.stats.tails import tail
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.candidates import candidates_of, ruled_out
from pipeline.storage.stage import entry


def main(
    *, scene: str, placed: Path, candidates: Path, anchors: Path, out: Path, table: Path, map: Path
) -> None:
    """Reads the candidates and their evaluations; writes where the search stands.

    ``placed`` is the file of all candidates, ``candidates`` the folder of those of the scene that were
    tried; ``out`` (JSON) has the answer, ``table`` (CSV) a line for each candidate, ``map`` (CSV) a surface
    for the eye.
    """
    method = params.scene_section(RankingParams, "ranking", scene=scene)
    procedure = params.section(HalvingParams, "searches", scene, "procedure")
    sizes = params.race(scene)
    rules = Rules(sizes.first, sizes.most, method.tolerance, tail(method.confidence, sizes.most))
    views, most = candidates_of(scene, placed), procedure.most_trainings
    _refuse_too_few(scene, len(views), procedure, rules)
    searched = read_searched(
        scene, views, candidates, anchors, sizes.first, params.sight_share(), mixture_allowed()
    )
    search = stand(searched, procedure.finalists, rules, most)
    found = search_content.found_answer(scene, searched, search, method.confidence)
    line = search_content.progress_line(scene, searched, search, found)
    parts = search_content.search_parts(searched, search, method.confidence)
    said = {
        "scene": scene,
        "confidence": method.confidence,
        "tolerance": method.tolerance,
        "budget": params.budget(),
        "seed": params.seed(),
        "most_repeats": search.spent + rules.most,
        "trainings_left": None if most is None else most - sum(len(own) for own in searched.returns.values()),
        "answer": search_content.answer_part(found),
        "progress": line,
        **parts,
        "viewpoints": search_content.finalist_rows(searched, search, method.confidence),
        "ruled_out": ruled_out(scene, placed),
    }
    write_json(out, said)
    with writing(table) as aside:
        pl.DataFrame(search_content.table(scene, parts), infer_schema_length=None).write_csv(aside)
    with writing(map) as aside:
        _surface(searched).write_csv(aside)
    print(line)
    if found is not None and found.kind not in ("open", "cannot see"):
        print(f"{scene}: {said['answer']['sentence']}")


def _refuse_too_few(scene: str, views: int, procedure: HalvingParams, rules: Rules) -> None:
    """Says so where the trainings do not suffice for an answer."""
    least, most = least_trainings(views, procedure.finalists, rules.first), procedure.most_trainings
    if most is not None and most < least:
        raise BelvedereError(
            f"searches.{scene}.procedure.most_trainings = {most} is not valid: {views} candidates take "
            f"{least} trainings until their {min(views, procedure.finalists)} finalists are first compared."
        )


def _surface(searched: Searched) -> pl.DataFrame:
    """The surface where candidates are, on a grid; before any training without rows."""
    keys, repeats, scores = search_content.scores_by_training(searched)
    if not keys:
        return pl.DataFrame(schema={"theta_deg": pl.Int64, "phi_deg": pl.Int64, "mean": float, "sd": float})
    at = grid([view.direction for view in searched.views.values()])
    tried = unit_vectors([searched.views[key].direction for key in keys])
    found = surface(tried, repeats, scores, unit_vectors(at))
    theta, phi = at.T
    return pl.DataFrame({"theta_deg": theta, "phi_deg": phi, "mean": found.mean, "sd": found.sd})


if __name__ == "__main__":
    entry(main)
