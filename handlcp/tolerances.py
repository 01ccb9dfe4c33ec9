"""The tolerances that decide what is an answer and what is proven, relative unless they say otherwise.

Solvers work in nondimensional units, so one number serves metres and millimetres, newtons and kilonewtons.
A threshold that serves one computation alone stands beside it.

Which decides what:

| decision | tolerance |
| --- | --- |
| `status` is SOLVED, and `held`: every residual passes | `CERTIFY_TOLERANCE`, 1e-8 |
| "separated", "sticking", "sliding" of each contact | `ACTIVE_TOLERANCE`, 1e-7 |
| OVER LIMIT: a torque, a tension or a range is exceeded | `OVER_LIMIT_TOLERANCE`, 1e-6 |
| UNDECIDED: motions are too large for one solve | `MAX_FORCE_SHARE`, 1; adrift: `NOTICED_SHARE`, 0.05 |
"""

from __future__ import annotations

# What a solver aims for: natural residual in nondimensional units. Newton's last step usually reaches 1e-14.
SOLVE_TOLERANCE = 1e-10

# ... and where friction limits of 1e-6 ask more of a residual than the rest does.
FINE_SOLVE_TOLERANCE = SOLVE_TOLERANCE * 1e-2

# What a certifier accepts as SOLVED: the worst residual relative to the scene. Two decades above the solvers' aim: the
# certifier measures other quantities than the solver (physics instead of the scaled complementarity problem).
CERTIFY_TOLERANCE = 1e-8

# Residuals are measured against the size of the answer where that exceeds the problem's own (rounding grows with the
# numbers), up to this many times: huge cancelling forces must not excuse a wrong answer.
MAX_RESIDUAL_GROWTH = 1e3

# A contact is called "on the limit", "touching" or "at rest" within this share of the scene's force or displacement.
ACTIVE_TOLERANCE = 1e-7

# A joint is over its torque limit, or past the end of its range, and an object farther than it may be, where it uses
# more than 1 + this of what there is. A limit that an answer or a path was led to is met to about 1e-8; motors and
# gears are known to no more than 1e-3.
OVER_LIMIT_TOLERANCE = 1e-6

# By how much the forces of one solve may be off, as a share of their size, because its equations are of small motions:
# from this share on the verdict is UNDECIDED. A contact that moves by the radius of the surface, or an object that
# turns by a radian, makes forces as wrong as they are large, and the equations say nothing any more.
MAX_FORCE_SHARE = 1.0

# ... and from this share on the verdict says so: 5 % is what friction coefficients and stiffnesses are known to, at
# best. Where nothing keeps the object in place (adrift), the verdict is UNDECIDED from here on, since the motion may be
# any.
NOTICED_SHARE = 0.05

# Free unknowns are eliminated when the estimated reciprocal condition of their block exceeds this: eliminating
# costs about eps / rcond in accuracy, which must stay well under what a certifier accepts.
MIN_ELIMINATION_RCOND = 1e-7

# Forces that come out of a problem made of themselves: solved again until they change by no more than this share.
FIXED_POINT_TOLERANCE = 1e-10

# Singular values (and complete pivots) below this share of the largest count as zero.
RANK_TOLERANCE = 1e-10

# Lemke: a pivot below this share of its column is no pivot; ratios closer than this are a tie.
PIVOT_TOLERANCE = 1e-11

# Matrices users pass: symmetric to this share of the largest entry; eigenvalues negative by this share count as zero.
SYMMETRY_TOLERANCE = 1e-9
SEMIDEFINITE_TOLERANCE = 1e-9

# Numbers users pass may be this large in size (and their reciprocals, squared, still fit a float64): more than any
# unit of length or force could make of a hand. Raw complementarity problems are scaled first and may be larger.
MAX_NUMBER = 1e60
MAX_RAW_NUMBER = 1e150

# A soft finger's moment is worked with as a force at the lever μ_τ/μ, and its flexibility grows as the lever squared.
# Beyond this many sizes of the grasp rounding alone is more than a solver aims for: 2e-16 · lever² > 1e-10.
MAX_LEVER = 1e3

# Friction coefficients of soft fingers: beyond it, where the moment matters at all, the lever is so short that it falls
# below what counts as zero, and a proof would overlook the moment.
MAX_SOFT_FINGER_FRICTION = 1e4

# Length of a normal may differ from one by this (absolute: a normal has no unit).
UNIT_NORMAL_TOLERANCE = 1e-6

# An object snaps where it goes so many times farther than it was about to, and by more than the last number (of the
# contacts' distances, turns in radians).
SNAP_RATIO = 5.0
MIN_SNAP_DISTANCE = 2e-3
