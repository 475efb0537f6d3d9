"""The sections of texts.yaml: which texts there are, page by page. The page reads them by these names."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from pipeline.contract.params import Section

Words = Annotated[str, StringConstraints(pattern=r"\S")]
Paragraphs = Annotated[tuple[Words, ...], Field(min_length=1)]
Version = Annotated[str, StringConstraints(pattern=r"^[\w.-]{1,40}$")]
Language = Annotated[str, StringConstraints(pattern=r"^[a-z]{2,3}(-[A-Za-z0-9]{2,8})*$")]


class Consent(Section):
    """The consent; its version names the wording that was agreed to."""

    version: Version
    heading: Words
    paragraphs: Paragraphs
    agree: Words
    accept: Words
    decline: Words


class Instructions(Section):
    """What the participant will do."""

    heading: Words
    paragraphs: Paragraphs
    extent: Words
    controls: Words
    next: Words


class Row(Section):
    """One control: what it does in either frame of the sticks, and where it is."""

    robot: Words
    camera: Words
    gamepad: Words
    keyboard: Words


class Rows(Section):
    """The controls."""

    left: Row
    right: Row
    a: Row
    start: Row
    pause: Row


class Controls(Section):
    """The table of controls."""

    does: Words
    gamepad: Words
    keyboard: Words
    rows: Rows
    speed: Words
    robot: Words
    camera: Words


class Steps(Section):
    """What the gamepad test asks for."""

    rest: Words
    left: Words
    right: Words
    a: Words
    start: Words


class Gamepad(Section):
    """The gamepad test."""

    heading: Words
    lede: Words
    waiting: Words
    connected: Words
    disconnected: Words
    unsupported: Words
    left: Words
    right: Words
    buttons: Words
    pressed: Words
    a: Words
    start: Words
    pause: Words
    inside: Words
    outside: Words
    steps: Steps
    step_done: Words
    step_open: Words
    drift: Words
    drift_bad: Words
    next: Words
    keyboard: Words


class Practice(Section):
    """Practice."""

    heading: Words
    short: Words
    left_over: Words
    most_left: Words
    next: Words


class Ready(Section):
    """Before a trial."""

    heading: Words
    place: Words
    begin: Words
    next: Words


class Trial(Section):
    """A trial."""

    heading: Words
    picture: Words
    waiting: Words
    pause: Words


class Axes(Section):
    """The directions of a frame."""

    x: Words
    y: Words
    z: Words


class FreeAxes(Section):
    """Which directions a task leaves free."""

    moves: Words
    last: Words
    robot: Axes
    camera: Axes


class Task(Section):
    """A scene's task."""

    name: Words
    sentence: Words


class Feedback(Section):
    """After a trial, where feedback is on."""

    heading: Words
    grasped: Words
    timeout: Words
    aborted: Words
    next: Words


class Paused(Section):
    """A pause."""

    heading: Words
    paragraphs: Paragraphs
    practice: Words
    next: Words


class Break(Section):
    """Between two blocks."""

    heading: Words
    paragraphs: Paragraphs
    next: Words


class Scale(Section):
    """One scale of NASA-TLX."""

    name: Words
    question: Words
    low: Words
    high: Words


class Scales(Section):
    """The six scales of NASA-TLX."""

    mental: Scale
    physical: Scale
    temporal: Scale
    performance: Scale
    effort: Scale
    frustration: Scale


class Tlx(Section):
    """NASA-TLX."""

    heading: Words
    lede: Words
    unanswered: Words
    value: Words
    missing: Words
    next: Words
    scales: Scales


class Thanks(Section):
    """The end."""

    heading: Words
    paragraphs: Paragraphs
    code: Words
    declined: Words


class Failure(Section):
    """What went wrong, what to do, and the button that tries again."""

    heading: Words
    text: Words
    next: Words


class Errors(Section):
    """What can go wrong; the keys are the reasons of the protocol's page ``error``."""

    lost: Failure
    stopped: Failure
    taken: Failure
    link: Failure
    protocol: Failure
    storage: Failure


class Flags(Section):
    """What a trial is flagged for."""

    latency: Words
    real_time: Words


class Bar(Section):
    """The experimenter's bar."""

    label: Words
    renderer: Words
    rate: Words
    latency: Words
    factor: Words
    flags: Flags
