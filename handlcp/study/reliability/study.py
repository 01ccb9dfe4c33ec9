"""How sure is it that a grasp holds, when friction, springs, masses and places are not known exactly?"""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import cores, integer, number
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.grasp.grasp import Grasp
from handlcp.keywords import helped
from handlcp.progress import Progress
from handlcp.study.reliability.by_number import placer_of
from handlcp.study.reliability.interval import Chance, chance_of, influences
from handlcp.study.reliability.outcome import CHECK, SOLVE, WORDS, Outcomes
from handlcp.study.reliability.place import Placer
from handlcp.study.reliability.result import Reliability
from handlcp.study.reliability.run import BLOCKS, Blocks, Kept, Method, blocks_of, question_of, run, slopes_of
from handlcp.study.reliability.spread import read_spread

_LOOKED_AT = 2**17  # samples from which is read off what matters


@helped()
def reliability(
    grasp: Grasp,
    spread: Any,
    samples: int = 10_000,
    *,
    seed: int = 0,
    faces: int | str | Pyramid = "cone",
    by: str = SOLVE,
    confidence: float = 0.95,
    decide: int = 200,
    workers: int | None = None,
    progress: Progress = None,
    resume: Any = None,
) -> Reliability:
    """The chance that a grasp holds, and that it does within its torque limits, when what it is made of varies.

    spread : what varies, each on its own, by name. A number is a standard deviation; a frozen distribution of
        scipy.stats says it all.
        "friction" : of the fingers' contacts, one coefficient for all. A share of the coefficient, or a distribution of
            the coefficient. By contact name: each its own, the environment's contacts among them.
        "stiffness" : of the joints, "pads" : flexibility of the fingertips' pads. A share, or a distribution of a
            factor. By joint, or by fingertip: each its own. A grasp without a hand: stiffness of all its fingers.
        "mass" : of the object. A share, or a distribution [kg].
        "load" : what loads the object besides its weight. A share, or a distribution of a factor.
        "squeeze" : how hard the hand closes, preloads and commands. A share, or a distribution of a factor.
        "positions" : where each contact is, along both tangents [m]. It stays on the surface of a ball, box, cylinder
            or ellipsoid, and its normal turns with that; elsewhere it moves in its tangent plane. By finger: those. A
            sample with a contact past an edge of a box or a rim of a cylinder is UNDECIDED, whatever `by` is: it has no
            normal there.
        "posture" : how far each joint stands from where it is said to be [rad, m]; the fingertip goes along, and its
            squeeze changes by as much. By joint: those.
        A number of the hand, by its name for `Hand.vary`, such as "finger_1_distal.length" or "joint_stiffness" : a
            share, or a distribution [SI]. The grasp is made anew as by `vary_grasp`, some 10 milliseconds a sample;
            where fingertips do not come to touch again it is UNDECIDED. Not beside "positions" and "posture".
        A share of 0.1 is lognormal with the nominal value as its mean and a tenth of it as its standard deviation: it
        is never negative. Metres and radians are normal about 0. Of a distribution that reaches below the least
        possible value, up to a millionth is cut off; with more it is refused.
    samples : at least so many, ≥ 64; rounded up to 16 to 32 blocks of a power of two.
    by : "solve": one certified solve for small motions, squeeze and load together: 10 to 50 microseconds a sample once
        kernels are compiled. A sample that moves too far for that is UNDECIDED, as `solution.verdict` calls it.
        "check": `grasp.check()`, squeezed, then loaded, contacts followed: 10 milliseconds a sample, and 0.1 to 0.4 s
        where positions and posture vary. Postures that a hand cannot take are UNDECIDED there.
    confidence : of the intervals. decide : of the samples that the first stage of the solver leaves open, so many are
        solved in full, with proofs; they tell how many of the others hold, and the interval grows by that.
    workers, progress : as in `solve_many`. seed : of the points; the same seed gives the same bits.
    resume : a file (.npz) that keeps what is done: the same call goes on where an interrupted one was.

    Sobol points, scrambled in independent blocks, fill the space of what varies; each sample is a whole grasp. Its word
    is that of a verdict: HELD, OVER LIMIT (held, but a joint is over its limit), NOT HELD or UNDECIDED. The lower end
    of an interval counts UNDECIDED as not held, the upper one as held.

    Raises InputError, UnknownName; InputError also for a `resume` file of another question.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    if by not in (SOLVE, CHECK):
        raise InputError("by", f'"{SOLVE}" or "{CHECK}"', repr(by)[:80])
    section = as_section(faces, planar=grasp.scene.kind.planar)
    level = number("confidence", confidence, above=0.0)
    if level >= 1.0:
        raise InputError("confidence", "a number below 1", confidence)
    placer = placer_of(grasp, read_spread(grasp, spread))
    blocks = blocks_of(integer("seed", seed, 0), len(placer.dimensions), integer("samples", samples, 4 * BLOCKS, 2**30))
    method = Method(by, faces, cores(workers), integer("decide", decide, 0))
    question = question_of(
        grasp.spec,
        placer.dimensions,
        seed=blocks.seed,
        samples=blocks.samples,
        faces=str(section),
        by=by,
        decide=method.decide,
    )
    found = run(placer, blocks, method, Kept(resume, question), progress)
    return _answer(found, placer, blocks, method, level)


def _answer(found: Outcomes, placer: Placer, blocks: Blocks, method: Method, level: float) -> Reliability:
    """What the outcomes of all samples say. level : confidence of the intervals."""
    some = min(blocks.samples, _LOOKED_AT)
    names = [(d.name, d.unit, d.law.sd) for d in placer.dimensions]
    matter = influences(names, blocks.points(0, some), found.margin[:some], slopes_of(placer, method))
    mechanism = placer.spec.mechanism
    limited = mechanism is not None and bool(np.isfinite(mechanism.limits).any())
    return Reliability(
        chance_held=_chance(found, 2, blocks.size, level),
        chance_within_limits=_chance(found, 1, blocks.size, level) if limited else None,
        counts={word: int((found.codes == code).sum()) for code, word in enumerate(WORDS)},
        influences=tuple(matter),
        outcomes=found,
        blocks=blocks,
        placer=placer,
        method=method,
    )


def _chance(found: Outcomes, worse: int, size: int, level: float) -> Chance:
    """The chance of a code below `worse`. size : samples of a block. level : confidence of the interval."""
    good, unknown = found.codes < worse, found.codes == len(WORDS) - 1
    looked = ~found.again & ~found.unplaced & ~found.far
    left = unknown & looked if found.again.any() else np.zeros(len(good), bool)
    return chance_of(good, left, unknown & ~left, (found.again, found.again & good), size, level)
