"""How an answer responds to changes: one elimination for all of them, and one side after the other at a kink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.effects.contact_compliance import ContactCompliance
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.change import Change, Rates, Stand, solved
from handlcp.grasp.sensitivity.kinks import Kink, kinks_at, one_sided
from handlcp.grasp.sensitivity.rows import respond
from handlcp.grasp.verify.contact_states import States
from handlcp.lazy import lazy
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import RANK

# ----------------------------------------------------------------
# The derivatives that are asked for most, together and compiled, of an answer in its ordinary case.
#
# That is: nothing is left free, no contact is at a kink, no limit gives way, and neither a soft palm nor turning levers
# take part. The equations are those of the parameters (`grasp/parameter`), which serve every other case; a test holds
# both against each other.

ORDINARY = ("wrench", "squeeze", "pads", "friction", "positions", "joint_offset", "stiffness")  # in this order


@kernel
def ordinary_changes(
    positions: Array, frames: Array, forces: Array, omega: Array, scale: Array, J: Array, C: Array, give: Array,
    moved: Array, angular: Array, planar: bool,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """(motion (c, p), balance (6, p), torque (nv, p)) of `Change`, by the parameters in `ORDINARY`.

    forces (c,), frames, J (c, nv), C (nv, nv), angular (n, 3, nv) : as in `Answer`, SI, contact axes. omega (3,) : of
    the object. give (nv,) δ, and moved (nv,) δ - δq of the joints.
    """
    n, (c, nv) = len(positions), J.shape
    p = 6 + 6 * n + 2 * nv
    v, b, tau = np.zeros((c, p)), np.zeros((6, p)), np.zeros((nv, p))
    for k in range(6):
        b[k, k] = 1.0
    f, w, e = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(n):
        v[3 * i + 2, 6 + i] = -1.0
        for a in range(3):
            v[3 * i + a, 6 + n + i] = forces[3 * i + a]
            f[a], w[a] = 0.0, omega[a]
            for k in range(3):
                f[a] += frames[i, a, k] * forces[3 * i + k]
            for j in range(nv):
                w[a] += angular[i, a, j] * moved[j]
        for a in range(3):
            at, x, y = 6 + 3 * n + 3 * i + a, (a + 1) % 3, (a + 2) % 3
            b[3 + x, at], b[3 + y, at] = -f[y], f[x]  # e × f
            e[a], e[x], e[y] = 0.0, w[y], -w[x]  # w × e
            for k in range(3):
                v[3 * i + k, at] = frames[i, 0, k] * e[0] + frames[i, 1, k] * e[1] + frames[i, 2, k] * e[2]
            for j in range(nv):
                tau[j, at] = angular[i, y, j] * f[x] - angular[i, x, j] * f[y]
    if nv > 0:
        JC = np.dot(J, C)
        first, last = 6 + 3 * n, 6 + 6 * n
        for r in range(c):
            for j in range(nv):
                x = JC[r, j]
                v[r, last + j] = -J[r, j]
                v[r, last + nv + j] = -x * give[j]
                if x != 0.0:
                    for k in range(first, last):
                        v[r, k] += x * tau[j, k]
    for r in range(c):
        for k in range(p):
            v[r, k] *= scale[r]
            if planar and r % 3 == 1:
                v[r, k] = 0.0
    return v, b, tau


@kernel
def ordinary_rates(
    G: Array, inverse: Array, tangent: Array, freedom: Array, scale: Array, room: Array, v: Array, b: Array,
    sizes: Array, twist_units: Array, balance_sizes: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """(forces (c, p), motion (6, p), slip (c, p)) of `Rates`.

    room (n,) : what friction bears more per unit of its coefficient [N]. v, b : of `ordinary_changes`.
    """
    c, dof, n, p = len(scale), len(freedom), len(room), v.shape[1]
    rhs = np.zeros((c + dof + n, p))
    for r in range(c):
        for k in range(p):
            rhs[r, k] = v[r, k] / sizes[1]
    lowered = np.dot(freedom, b)
    for r in range(dof):
        for k in range(p):
            rhs[c + r, k] = lowered[r, k] / balance_sizes[r]
    for i in range(n):
        rhs[c + dof + i, 6 + 2 * n + i] = room[i] / sizes[0]
    x = np.dot(inverse, rhs)
    for r in range(c):
        for k in range(p):
            x[r, k] *= sizes[0]
    for r in range(dof):
        for k in range(p):
            x[c + r, k] *= twist_units[r]
    motion = np.dot(freedom.T.copy(), x[c : c + dof])
    slip = np.dot(G.T.copy(), motion) + np.dot(tangent, x[:c]) + v
    forces = x[:c].copy()
    for r in range(c):
        for k in range(p):
            forces[r, k] *= scale[r]
            slip[r, k] /= scale[r]
    return forces, motion, slip


# ----------------------------------------------------------------

_AS_USUAL = (JointOffset, FingerWeight, ContactCompliance)  # effects that are data, and stay while contacts move
_FREE = 1e-7  # what the free directions of a singular system move by less is determined


@dataclass(frozen=True, eq=False)
class Response:
    """Of an answer. inverse : (c + dof + m, c + dof + n + m) changes in natural units by unit right-hand sides, in the
    order of `rows.active_rows`; only where `regular`: nothing is left free.
    """

    at: Stand
    inverse: Array
    regular: bool

    @classmethod
    def of(cls, answer: Answer) -> Response:
        """One call of compiled code."""
        s, given, reached = answer.scene, answer.scene.given, answer.yielding
        G, v, kind, against, faces, turn, edge, inverse, regular = respond(
            given.positions, given.frames, given.spin, given.flexibility, answer.opening, answer.tangent,
            given.freedom, answer.spec.reference, answer.lawful, answer.twist, s.kind.contact_components,
            answer.friction, reached.rows[: reached.active], answer.sizes,
        )  # fmt: skip
        return cls(Stand(answer, G, v, States(kind, against, faces, turn), edge), inverse, regular)

    @lazy
    def kinks(self) -> tuple[Kink, ...]:
        """Contacts and limits whose next state depends on the direction of the change."""
        return kinks_at(self.at)

    @lazy
    def free(self) -> Array:
        """(k, j) what spans the changes that no law resists, natural units; j = 0: there are none."""
        if self.regular:
            return np.zeros((len(self.inverse), 0))
        reached = self.at.answer.yielding
        A, _ = self.at.equations(self.at.states, reached.rows[: reached.active])
        return solved(A, np.zeros((len(A), 0)), RANK)[1]

    @lazy
    def ordinary(self) -> dict[str, tuple[Rates, Change]]:
        """Rates and changes by the parameters in `ORDINARY`, made together; empty out of the ordinary case."""
        at, answer = self.at, self.at.answer
        spec, s, mechanism = answer.spec, answer.scene, answer.spec.mechanism
        strange = any(not isinstance(e, _AS_USUAL) for e in spec.effects)
        if strange or not self.regular or self.kinks or (mechanism is not None and not answer.elastic_joints):
            return {}
        nv = answer.rows.shape[1]
        joints = answer.joints
        moved = joints.deflection - answer.command
        angular = np.zeros((s.n, 3, 0)) if mechanism is None else mechanism.angular()
        v, b, tau = ordinary_changes(
            spec.positions, spec.frames, answer.components, answer.twist[3:], answer.scale, answer.rows,
            answer.compliance, joints.deflection, moved, angular, spec.planar,
        )  # fmt: skip
        share = answer.friction_shares
        room = share * answer.lawful[2 : 3 * s.n : 3]
        forces, motion, slip = ordinary_rates(
            at.G, self.inverse, answer.tangent, s.given.freedom, answer.scale, room, v, b, answer.sizes,
            s.twist_units, answer.balance_sizes,
        )  # fmt: skip
        found, first = dict[str, tuple[Rates, Change]](), 0
        for name, count in zip(ORDINARY, (6, s.n, s.n, s.n, 3 * s.n, nv, nv), strict=True):
            own = slice(first, first + count)
            mu = np.diag(share) if name == "friction" else np.zeros((s.n, count))
            change = Change(v[:, own], b[:, own], mu, tau[:, own], np.zeros((nv, count)))
            found[name] = Rates(forces[:, own], motion[:, own], slip[:, own]), change
            first += count
        return found

    def to(self, change: Change) -> Rates:
        """The rates; at a kink those of a growing parameter, column by column."""
        at, reached = self.at, self.at.answer.yielding
        b, rows = at.right_hand_sides(change), reached.rows[: reached.active]
        if self.kinks:
            found = [one_sided(at, self.kinks, b[:, k]) for k in range(b.shape[1])]
            none = np.zeros((len(self.inverse) + len(reached.at) - reached.active, 0))
            rates = self._rates(np.column_stack([none, *[x for x, _ in found]]), reached.rows, change)
            for k, (_, free) in enumerate(found):
                self._leave_open(rates, slice(k, k + 1), free, reached.rows)
            return rates
        if self.regular:
            x = self.inverse @ b
        else:
            A, B = at.equations(at.states, rows)
            x = solved(A, B @ b, RANK)[0]
        rates = self._rates(x, rows, change)
        self._leave_open(rates, slice(None), self.free, rows)
        return rates

    def _rates(self, x: Array, limits: Array, change: Change) -> Rates:
        """In SI and contact axes."""
        at, c = self.at, self.at.answer.scene.components
        scale = at.answer.scale[:, None]
        forces, motion = x[:c] * at.answer.sizes[0] * scale, at.motion(x)
        slip = (at.moved(x, limits) + change.motion) / scale
        return Rates(forces, motion, slip)

    def _leave_open(self, rates: Rates, columns: slice, N: Array, limits: Array) -> None:
        """Write NaN into columns of rates, for what N (k, j) leaves free."""
        if not N.shape[1]:
            return
        at, units, c = self.at, self.at.answer.sizes, self.at.answer.scene.components
        rates.forces[abs(N[:c]).max(axis=1) > _FREE, columns] = np.nan
        moved = at.motion(N) / (units[1] / np.array((1.0,) * 3 + (units[2],) * 3))[:, None]
        rates.motion[abs(moved).max(axis=1) > _FREE, columns] = np.nan
        rates.slip[abs(at.moved(N, limits)).max(axis=1) > _FREE * units[1], columns] = np.nan
