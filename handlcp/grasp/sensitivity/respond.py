"""How an answer responds to changes: one elimination for all of them, and one side after the other at a kink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.effects.contact_compliance import ContactCompliance
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.change import Change, Rates
from handlcp.grasp.sensitivity.kinks import Kink, kinks_at, one_sided
from handlcp.grasp.sensitivity.ordinary import ORDINARY, ordinary_changes, ordinary_rates
from handlcp.grasp.sensitivity.rows import respond
from handlcp.grasp.sensitivity.stand import Stand, solved
from handlcp.grasp.verify.contact_states import States
from handlcp.lazy import lazy
from handlcp.tolerances import RANK

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
