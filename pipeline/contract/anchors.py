"""Is a scene's task one that a camera can matter to? What its anchors say of that, in sentences."""

from __future__ import annotations

LEAST_FOR_SIGHT = 1 / 3  # of what the expert earns over doing nothing, that sight has to give
LEAST_DONE = 0.95  # of the expert's episodes, that it has to bring within 2 cm


def anchor_warnings(scene: str, no_op: float, blind: float, expert: float, done: float) -> list[str]:
    """One sentence for each thing that makes a ranking of the scene's views say little.

    Args:
        scene: its name in params.yaml.
        no_op: mean return of doing nothing, m.
        blind: of who never sees the target.
        expert: of who is told everything.
        done: share of the expert's episodes in which the task was done to within 2 cm.
    """
    found = []
    if expert - blind < LEAST_FOR_SIGHT * (expert - no_op):
        found.append(
            f"In scene {scene} the target-blind policy returns {blind:.2f} m, near the expert's "
            f"{expert:.2f} m (doing nothing returns {no_op:.2f} m): sight has little to give, so viewpoints "
            "can hardly differ; let its targets differ more between episodes."
        )
    if done < LEAST_DONE:
        found.append(
            f"In scene {scene} the expert comes within 2 cm in only {done:.0%} of the episodes, so a score "
            "of 1 is no task well done; give it more frames, or make the task easier for the arm."
        )
    return found
