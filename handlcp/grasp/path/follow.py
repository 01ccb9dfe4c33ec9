"""A grasp followed through its loading: whether the end is reached, what happens on the way, and where it is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, check_integer, check_method_calls, check_number, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.path_sensitivity import PathSensitivity
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.failure.failure_mode import OBJECT, find_exceeded, state_limits
from handlcp.grasp.failure.failure_text import describe_load_share, describe_slip, explain_giving_up, explain_loss
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.advance import PATIENT, Patience, advance, read_accuracy
from handlcp.grasp.path.events import Event, Summary, summary
from handlcp.grasp.path.geometry import FixedGeometry, Geometry
from handlcp.grasp.path.state import Controls, Goal, Jump, Run, Slides, State, first_of, read_stages
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.step_grasp import StepGrasp
from handlcp.grasp.path.trajectory import Steps
from handlcp.grasp.path.watch import MAX_SLIP, is_at_max_slip, read_max_slip, watch_of
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import HELD, NOT_HELD, OVER_LIMIT, UNDECIDED
from handlcp.grasp.solve.solve_spec import certify_known_answer, solve_spec
from handlcp.lazy_property import lazy_property
from handlcp.progress import track_progress
from handlcp.record import Record, make_data_frame, package_versions, pick_entries
from handlcp.words import wrap_text

_COARSER = 100.0  # times as wide as differences of one solve are those of whole paths, whose steps limit them
TOLERANCE = 1e-9  # of the contacts' radii: how far the end of a step may be from where its geometry was taken


@check_method_calls
@dataclass(frozen=True, eq=False)
class Loading(Record):
    """What becomes of a grasp under loading in steps; made by `Grasp.follow`. Does it hold? `held` and `word` say so.

    reached : whether the path goes on to the end of the last stage, even if the object slid away or snapped to another
    place on the way: `held` says whether the object is held. lost_at : share of the stage that was reached when the
    object was lost, lost_stage : its name; None where it was not. why : one sentence.
    events : in order. steps : every step as arrays. stages : their names. section : of the friction cones. slides :
    where a contact that presses has slid `max_slip` since the load began, jump : where the loaded object snaps; None:
    nowhere. max_slip (n,) : how far each contact may slide [m]. outcome : how the path ends. accuracy : estimated error
    of the forces, the largest of a step, as a share of the largest force. again : follows another grasp in the same
    way.
    """

    entries = (
        "word", "held", "reached", "lost_at", "lost_stage", "why", "stages", "geometry", "events", "summary",
        "object_displacement (twist) = displacement", "status_at_end = solution.status",
        "steps.stage (m,)", "steps.share (m,)", "steps.load_N_Nm (m, 6)", "steps.weight (m,)",
        "steps.displacement_m_rad (m, 6)",
        "contacts.names (n,) = steps.names", "contacts.forces_N (m, n, 3) = steps.forces",
        "contacts.forces_world_N (m, n, 3) = steps.forces_world", "contacts.torsion_Nm (m, n) = steps.torsion",
        "contacts.friction_used (m, n) = steps.friction_used", "contacts.state (m, n) = steps.contact_state",
        "contacts.gap_m (m, n) = steps.gap", "contacts.slip_m (m, n, 2) = steps.slip",
        "contacts.position_m (m, n, 3) = steps.positions", "contacts.slip_on_the_way_m (n, 2) = steps.slip_on_the_way",
    )  # fmt: skip

    reached: bool
    lost_at: float | None
    lost_stage: str | None
    why: str
    events: tuple[Event, ...]
    steps: Steps
    stages: tuple[str, ...]
    section: Section
    slides: Slides | None = None
    jump: Jump | None = None
    max_slip: Array = field(default_factory=lambda: np.zeros(0))
    outcome: PathStatus = PathStatus.REACHED
    accuracy: float = np.nan
    again: Callable[[GraspSpec], Loading] | None = field(default=None, repr=False)

    @property
    def held(self) -> bool:
        """Whether the whole load is held: the end is reached, no contact has slid as far as `max_slip` since the load
        began, the loaded object has not snapped (how far it jumps is for its inertia to say, not for statics), and at
        the end everything is within its limits.
        """
        return self.word == HELD

    @property
    def in_place(self) -> bool:
        """The same whatever joints and tendons would have to bear."""
        return self.reached and self.gives_way is None

    @property
    def gives_way(self) -> Slides | Jump | None:
        """Where the object begins to leave its place: a contact has slid too far, or it snaps; None: nowhere."""
        return first_of(self.slides, self.jump)

    @property
    def word(self) -> str:
        """As a verdict has it: "HELD"; "OVER LIMIT": held, and at the end a joint or tendon is over its limit; "NOT
        HELD"; "UNDECIDED": the path was given up. `Grasp.check` judges more, such as links inside the object.
        """
        if self.outcome.is_given_up:
            return UNDECIDED
        return NOT_HELD if not self.in_place else OVER_LIMIT if self._over else HELD

    @property
    def sentence(self) -> str:
        """What stands behind the word: `why`, and what is over its limit at the end; where a contact slides too far or
        the object snaps although the end is reached, that, and from where on.
        """
        if not self.reached:
            return self.why
        gives_way = self.gives_way
        if gives_way is None:
            return "; ".join(
                [self.why, *([f"over the limit there: {words.list_names(self._over)}"] if self._over else [])]
            )
        does = "the object snaps to another place" if gives_way is self.jump else self.slid_too_far
        at = f"{words.format_percent(gives_way.share)} of stage {self.stages[gives_way.stage]!r}"
        return f"{does} at {at}; loaded slowly, it {self.why} all the same"

    @property
    def slid_too_far(self) -> str:
        """Which contacts slide too far first, in words; "" for none."""
        if self.slides is None:
            return ""
        slipped = self.steps.slipped[self.slides.number]
        who = np.flatnonzero(is_at_max_slip(slipped, self.max_slip))
        return describe_slip([self.steps.names[k] for k in who], float(slipped[who].max()))

    @property
    def _over(self) -> list[str]:
        """Joints and tendons that are over their limit at the last step."""
        return [
            cause.who for cause in find_exceeded(state_limits(self.steps.grasp.spec, ranges=False), self.last.efforts)
        ]

    @property
    def held_to(self) -> float:
        """Share of the last stage that was begun up to which the object is held; 1 at the end."""
        if (gives_way := self.gives_way) is not None and gives_way.stage == int(self.steps.stage[-1]):
            return gives_way.share
        return 1.0 if self.lost_at is None else self.lost_at

    @property
    def last(self) -> State:
        """The last step."""
        return self.steps.states[-1]

    @lazy_property
    def solution(self) -> GraspSolution:
        """The last step as a certified solution of its own grasp: contact forces, torques, contact states. Its slip,
        gap and object motion are those of that step; `displacement` is the whole motion.
        """
        return solution_of(self.steps.grasp, self.last, self.section)

    def sensitivity(self) -> PathSensitivity:
        """Derivatives of the end of the path, with all its history, by differences of whole paths: forces (n, 3),
        torques (nv,), displacement (6,), such as `.displacement_by_wrench` (6, 6); `error` tells how far the two
        sides differ, events of the path and the size of its steps included. NaN where an end is not reached.
        """
        assert self.again is not None  # `follow` saw to it
        follow_again = self.again

        def end(spec: GraspSpec) -> dict[str, Array]:
            last = follow_again(spec)
            share = 1.0 if last.reached else np.nan
            read = last.last.read
            return {
                "forces": share * read.forces, "torques": share * read.torque, "displacement": share * last.displacement
            }  # fmt: skip

        return PathSensitivity(self.steps.grasp.spec, end, _COARSER)

    @property
    def displacement(self) -> Array:
        """(6,) of the object since the start: of the reference point [m], and its rotation vector [rad], world axes."""
        return self.steps.geometry.displacement(self.last.where.pose)

    @property
    def state(self) -> Any:
        """The hand's posture at the last step; None without a hand."""
        return self._end[0]

    @property
    def object(self) -> Any:
        """The object where it is at the last step; None where it is not known."""
        return self._end[1]

    @lazy_property
    def _end(self) -> tuple[Any, Any]:
        mechanism, where = self.steps.grasp.spec.mechanism, self.last.where
        if mechanism is None or not self.steps.geometry.follows:
            return None, None
        place: tuple[Any, Any] = mechanism.report.place_at(where.q, where.pose)
        return place

    def page(self, path: Any, *, obj: Any = None, title: str = "", verdict: Any = None) -> Path:
        """A page with a slider through all steps, as `GraspSolution.page`; obj : where it stands at the start."""
        from handlcp.viz import write_loading_page  # loadings pay for no page that nobody writes

        return write_loading_page(self, path, title, obj, verdict)

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The figure of the loading: forces, friction, object motion and torques over its stages, and its events.

        path : of a png, svg, pdf or jpg file; None: the matplotlib figure itself. Raises as `GraspSolution.plot`.
        """
        from handlcp.viz import draw_loading, draw_or_save  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_loading, self, title)

    def to_frame(self) -> Any:
        """A pandas table with a row for each step, as `steps.to_dict` has it. Raises Unsupported without pandas."""
        return make_data_frame(self.steps.to_dict(self.stages))

    @property
    def geometry(self) -> str:
        """As asked or chosen: "fixed" or "followed"."""
        return "followed" if self.steps.geometry.follows else "fixed"

    @lazy_property
    def summary(self) -> tuple[Summary, ...]:
        """The events in words, what several fingers do at one place as one."""
        return summary(self.events, self.steps.grasp.spec)

    def to_dict(self) -> dict[str, Any]:
        """The whole path as plain data: SI units in the key names, None for what is not a finite number."""
        found, mechanism = super().to_dict(), self.steps.grasp.spec.mechanism
        if not self.steps.grasp.soft.size:
            found["contacts"]["torsion_Nm"] = None
        joints = None
        if mechanism is not None:
            joints = pick_entries(mechanism, "names", "torque_limits_Nm = limits")
            joints |= pick_entries(self.steps, "torques_Nm", "command_rad", "q_rad")
        return found | {"joints": joints, "versions": package_versions("numpy")}

    def __repr__(self) -> str:
        return f"{self.word}: {self.sentence}."

    def __str__(self) -> str:
        """Whether it is held, in the words of a verdict; what happens on the way, and what the last step is like."""
        u, forces = self.displacement, self.steps.forces[-1, :, 2]
        moved = f"the object has moved {words.format_length(float(np.linalg.norm(u[:3])))}"
        if (turned := float(np.linalg.norm(u[3:]))) > 1e-4:
            moved += f" and turned {words.format_angle(turned)}"
        most = int(np.argmax(forces >= (1.0 - 1e-6) * forces.max()))  # the first of equals
        pressed = f"the largest normal force is {words.format_force(float(forces[most]))}, at {self.steps.names[most]}"
        if not forces[most] > 0.0:
            pressed = "nothing presses on it"
        when = "at the end" if self.reached else "at the last step"
        said = [str(s) for s in self.summary]
        lines = [wrap_text(f"{self.word}: {self.sentence}", "  "), *(wrap_text(line, "    ", "  ") for line in said)]
        return "\n".join([*lines, wrap_text(f"{when}: {moved}; {pressed}", "    ", "  ")])


def solution_of(grasp: StepGrasp, state: State, section: Section) -> GraspSolution:
    """A state of a path as a certified solution of its own grasp: its forces and motion, if the certifier agrees, else
    those that a solve finds from there.
    """
    made = grasp.made(state.iterate, state.loads, state.pull.tension if len(state.pull.tension) else None)
    scene = build_scene(made)
    c = scene.components
    if len(state.start) and not grasp.general:
        known = SolverCandidate(state.start[:c], state.start[c : c + 6], {}, len(scene.soft))
        if (found := certify_known_answer(made, scene, section, known, "a state of the path")).held:
            return found
    return solve_spec(made, section, start=state.start[: c + 9], proof=False)


@track_progress("following the loading")
def follow(
    spec: GraspSpec, section: Section, load: Array | None, order: Any, geometry: Any, steps: Any, tolerance: Any,
    accuracy: Any = None, max_slip: Any = MAX_SLIP, patience: Patience = PATIENT,
) -> Loading:  # fmt: skip
    """See `Grasp.follow`. load : (6,) or (m, 6); None: the grasp's own. patience : as in `advance`."""
    near = read_accuracy(accuracy)
    watch = watch_of(spec, body := geometry_of(spec, geometry), read_max_slip(max_slip, spec.names))
    count = check_integer("steps", steps, 1)
    limit = TOLERANCE if tolerance is None else check_number("tolerance", tolerance, above=0.0)
    first, goals, stepper = begun(spec, section, body, limit, order, load)
    run = advance(stepper, watch, first, goals, count, near, patience)

    again = partial(_again, load, section, order, geometry, (steps, tolerance, accuracy, max_slip))
    return replace(loading_of(run, goals, stepper, section, watch.max_slip), again=again)


def _again(
    load: Array | None, section: Section, order: Any, geometry: Any, options: tuple[Any, ...], other: GraspSpec
) -> Loading:
    """Another grasp followed in the same way. options : the other arguments of `follow`."""
    return follow(other, section, load, order, geometry, *options)


def beside_weight(spec: GraspSpec, stepper: Stepper) -> Array:
    """(6,) the grasp's own load besides the object's weight, about its reference."""
    beside = spec.wrench.copy()
    beside[:3] -= stepper.grasp.weight
    beside[3:] -= cross_rows(stepper.first.weight_arm, stepper.grasp.weight)
    return read_only(beside)


def begun(
    spec: GraspSpec, section: Section, body: Geometry, tolerance: float, order: Any, load: Array | None
) -> tuple[Controls, list[Goal], Stepper]:
    """The controls before anything is done, the stages, and what makes steps. Arguments as in `follow`."""
    if held := [e for e in spec.effects if e.prescribed()]:
        names = ", ".join(type(e).__name__ for e in held)
        raise Unsupported(f"forces that are known or prescribed cannot be followed through a loading ({names})")
    weight = np.zeros(6) if spec.mechanism is None else spec.mechanism.weight_of_object(spec.reference)
    stepper = Stepper(spec, body, section, weight[:3], tolerance)
    closing = find_command(spec.effects)
    command, kept = (np.zeros(len(body.posture)), False) if closing is None else (closing.motor_offset, closing.keeps)
    before = body.start.q - body.posture
    squeezes = stepper.grasp.squeezes or bool((command != before).any())
    weighs = bool(weight[:3].any())
    first, goals = read_stages(spec, order, load, beside_weight(spec, stepper), before, command, squeezes, weighs, kept)
    return first, goals, stepper


def is_followed(spec: GraspSpec, asked: Any) -> bool:
    """Whether contacts are followed: where a hand is known, but for "fixed". Raises InputError."""
    if asked not in (None, "followed", "fixed"):
        raise InputError("geometry", '"followed", "fixed" or None', repr(asked))
    if spec.mechanism is None and asked == "followed":
        expected = '"fixed" for a grasp without a hand: only its first posture is known'
        raise InputError("geometry", expected, repr(asked))
    return asked != "fixed" and spec.mechanism is not None


def geometry_of(spec: GraspSpec, asked: Any) -> Geometry:
    """Where contacts are on a path, as `is_followed` says. Raises InputError."""
    if not is_followed(spec, asked) or spec.mechanism is None:
        return FixedGeometry(spec)
    moving: Geometry = spec.mechanism.moving_geometry(spec)
    return moving


def loading_of(run: Run, goals: list[Goal], stepper: Stepper, section: Section, max_slip: Array) -> Loading:
    """What became of a grasp, from a run of these stages. max_slip (n,) : as in `Watch`."""
    spec = stepper.grasp.spec
    events, lost = list(run.events), run.status != PathStatus.REACHED
    number = run.under_way
    share = run.shares[-1] if number == run.stages[-1] else 0.0  # no state of this stage was found
    stage = goals[number].name if goals else None
    steps = Steps(
        np.array(run.stages),
        read_only(np.array(run.shares)),
        spec.names,
        tuple(run.states),
        stepper.grasp,
        np.array(run.slipped),
    )
    for snap in run.snaps:
        if snap.rests:
            at = goals[snap.stage].name, snap.share, snap.stage
            events.append(Event("snaps", OBJECT, *at, snap.moved, snap.turned, snap.pushed))
    if run.slides is not None:
        stage = goals[run.slides.stage].name
        for k in np.flatnonzero(is_at_max_slip(run.slipped[run.slides.number], max_slip)).tolist():
            events.append(Event("slides", spec.names[k], stage, run.slides.share, run.slides.stage))
        stage = goals[number].name
    events.sort(key=lambda e: (e.number, e.share))
    last = run.states[-1]
    if run.status.is_given_up:
        sentence = (
            f"given up in stage {stage!r} at {words.format_percent(share)}: {explain_giving_up(run.status, run.who)}"
        )
    elif lost:
        going = stepper.geometry.between(run.states[-2].where.pose, last.where.pose) if len(run.states) > 1 else None
        if run.status == PathStatus.UNSTABLE:
            going = np.array(run.snaps[-1].pushed)
        why = explain_loss(run.status, spec, last.kinds, going, goals[number].end.kept)
        events.append(Event("lost", why, str(stage), share, number))
        weight, end = np.append(stepper.grasp.weight, np.zeros(3)), goals[number].end
        now = last.controls
        under = describe_load_share(now.load + now.weight * weight, end.load + end.weight * weight)
        sentence = f"lost in stage {stage!r} at {words.format_percent(share)}{under}: {why}"
    else:
        few = " and ".join(repr(g.name) for g in goals)
        sentence = f"reached the end of {few if len(goals) < 3 else f'all {len(goals)} stages'}"
    names = tuple([g.name for g in goals])
    return Loading(
        not lost, share if lost else None, stage if lost else None, sentence, tuple(events), steps, names, section,
        run.slides, run.jump, max_slip, run.status, max(run.errors, default=0.0),
    )  # fmt: skip
