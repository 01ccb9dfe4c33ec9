"""Between what and what every contact force and joint torque lies where statics leaves forces open."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.answer.extremes import Extremes, extremes
from handlcp.grasp.answer.family import Ranges, kept_of, own_flexibility
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.friction import Pyramid
from handlcp.progress import told
from handlcp.record import Record
from handlcp.text_table import TextTable, wrapped
from handlcp.tolerances import ACTIVE

_NOISE = 1e-9  # of the scene's force: bounds that are apart by less are the same
_AS_IT_IS = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class ForceBounds(Record):
    """Least and largest, in the last axis, over all equilibria that keep the contact states of a solution; n contacts,
    nv joints. The same number twice where the equations determine it; -inf and inf where nothing bounds it.

    names : (n,) contacts. forces : (n, 3, 2) N, on the object in contact axes (x, y tangents, z normal).
    joints : (nv,) names, () without a hand. torques : (nv, 2) N·m, as `HandGraspSolution.torques`. limit : (nv,) N·m,
        inf where there is none or none is known.
    pads, friction : the factors that were asked for; (1, 1): as they are.
    wider : contacts that were allowed more than their laws allow: the direction of their slide may turn, their force
        lies on a face of a pyramid that the slip is not against, they touch without force and slip, or more than four
        touch without force. Where there are any, bounds may be wider than need be, never narrower; so with factors.
    gap : by how much a bound may be off, at most: what separates it from what its program proves, relative to the
        larger of it and the scene's force.
    """

    entries = (
        "names", "normal_N (n, 2)", "forces_N (n, 3, 2)", "joints", "torques_Nm (nv, 2)", "limit_Nm (nv,)",
        "utilisation (nv, 2)", "open", "pads", "friction", "wider", "gap",
    )  # fmt: skip

    names: tuple[str, ...]
    forces: Array
    joints: tuple[str, ...]
    torques: Array
    limit: Array
    pads: tuple[float, float]
    friction: tuple[float, float]
    wider: tuple[str, ...]
    gap: float
    force: float = field(repr=False)

    @property
    def normal(self) -> Array:
        """(n, 2) N, of the normal forces."""
        return self.forces[:, 2]

    @property
    def utilisation(self) -> Array:
        """(nv, 2) least and largest |torque| / limit, 0 where there is no limit or none is known."""
        return shares(self.torques, self.limit)

    @property
    def open(self) -> tuple[str, ...]:
        """The contacts and joints whose force or torque is not determined."""
        which = np.append(apart(self.forces, self.force).any(axis=1), apart(self.torques, self.force)).tolist()
        return tuple([name for name, yes in zip((*self.names, *self.joints), which, strict=True) if yes])

    def __str__(self) -> str:
        tables = [_table("contact", "normal", "N", self.names, self.normal)]
        if self.joints:
            tables.append(_table("joint", "torque", "N·m", self.joints, self.torques, self._shares))
        return "\n\n".join([*map(str, tables), wrapped(self._sentence)])

    @property
    def _shares(self) -> list[str]:
        """Such as "40 to 120 %"."""
        both = zip(self.utilisation.tolist(), np.isfinite(self.limit).tolist(), strict=True)
        return [span(low, high) if limited else "–" for (low, high), limited in both]

    @property
    def _sentence(self) -> str:
        text = f"Not determined: {words.all_of(self.open)}" if self.open else "All forces are determined"
        asked = [f"{what} from {least:g} to {most:g} times what they are"
                 for what, (least, most) in (("pads", self.pads), ("friction", self.friction))
                 if (least, most) != _AS_IT_IS]  # fmt: skip
        if asked:
            text += f", with {' and '.join(asked)} where contacts go on doing what they do"
        if self.wider or asked:
            text += "; the bounds may be wider than need be, never narrower"
        return f"{text}."


def _table(
    who: str, what: str, unit: str, names: tuple[str, ...], bounds: Array, shares: list[str] | None = None
) -> TextTable:
    values = bounds.reshape(-1).tolist()
    name, size = words.prefixed(unit, values)
    cells = [c if np.isfinite(x) else "∞" if x > 0.0 else "-∞"
             for c, x in zip(words.column([x / size for x in values]), values, strict=True)]  # fmt: skip
    heads, columns = [who, f"least {what}\n{name}", f"largest\n{name}"], [list(names), cells[::2], cells[1::2]]
    if shares is not None:
        heads, columns = [*heads, "of limit"], [*columns, shares]
    return TextTable(tuple(heads), tuple(zip(*columns, strict=True)), "<>>>"[: len(heads)])


def apart(bounds: Array, force: float) -> Array:
    """(…,) whether the two in the last axis of bounds (…, 2) differ; force : of the scene [N]."""
    return np.asarray(~(bounds[..., 1] - bounds[..., 0] <= _NOISE * force))


def shares(torques: Array, limit: Array) -> Array:
    """(nv, 2) least and largest |torque| / limit of bounds (nv, 2) and limits (nv,), 0 where that is infinite."""
    low, high = torques.T
    least = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(abs(low), abs(high)))
    both, limited = np.column_stack([least, np.maximum(abs(low), abs(high))]), np.isfinite(limit)[:, None]
    return read_only(np.where(limited, both, 0.0) / np.where(limited, limit[:, None], 1.0))


def span(least: float, most: float) -> str:
    """Of a limit, such as "40 to 120 %"."""
    low, high = words.percent(least), words.percent(most)
    if not np.isfinite(most):
        return f"{low} to ∞" if np.isfinite(least) else "∞"
    return low if low == high else f"{low.removesuffix(' %')} to {high}"


# ----------------------------------------------------------------


@told("bounding forces")
def force_bounds_of(solution: Any, pads: Any, friction: Any) -> ForceBounds:
    """Of a `GraspSolution`; see there."""
    s = solution
    if not s.held or s.spec is None or s.scene is None:
        raise InputError("solution", "a solution that is held: others have no forces", s.status.name)
    if foreign := [e.title for e in s.spec.effects if not e.only_limits]:
        raise Unsupported(f"force_bounds: nobody knows what is left open beside {words.listed(foreign)}")
    factors = _factors("pads", pads), _factors("friction", friction)
    ranges = None if factors == (_AS_IT_IS, _AS_IT_IS) else Ranges(*factors, own_flexibility(s))
    scene, n, mechanism = s.scene, s.scene.n, s.spec.mechanism
    found, torques = Extremes(np.zeros((3 * n, 2)), np.zeros(n, bool), 0.0), torques_of(s)
    moved = np.zeros((len(torques), 2))
    if ranges is not None or not _determined(s):
        scale = np.ones(scene.components) if scene.scale is None else scene.scale
        found = extremes(kept_of(s), np.concatenate([np.diag(scale)[: 3 * n], _torque_rows(s) * scale]), ranges)
        moved = found.change[3 * n :] * scene.units.force
    forces = s.forces.reshape(-1, 1) + found.change[: 3 * n] * scene.units.force
    return ForceBounds(
        s.names, read_only(forces.reshape(n, 3, 2)), () if mechanism is None else mechanism.names,
        read_only(torques[:, None] + moved), np.zeros(0) if mechanism is None else mechanism.limits, *factors,
        tuple([name for name, yes in zip(s.names, found.wider.tolist(), strict=True) if yes]),
        found.gap, s.residuals.force_scale,
    )  # fmt: skip


def torque_bounds(s: Any) -> Array:
    """(nv, 2) `ForceBounds.torques` alone, of a solution that leaves forces open."""
    scale = np.ones(s.scene.components) if s.scene.scale is None else s.scene.scale
    found = extremes(kept_of(s), _torque_rows(s) * scale, None)
    return np.asarray(torques_of(s)[:, None] + found.change * s.scene.units.force)


def torques_of(s: Any) -> Array:
    """(nv,) N·m; none without a hand."""
    return np.asarray(getattr(s, "torques", np.zeros(0)))


def _determined(s: Any) -> bool:
    """Whether the solution itself says that forces are determined. It does not look at all that contacts and limits may
    do where they are at rest, nor at forces that may leave one of two faces.
    """
    near = 2.0 * ACTIVE * max(s.residuals.motion_scale, s.scene.units.motion)
    rests = [state == "separated" and gap <= near for state, gap in zip(s.contact_state, s.gap.tolist(), strict=True)]
    known = s.uniqueness is not None and s.uniqueness.forces_determined
    faces = isinstance(s.section, Pyramid) and "sliding" in s.contact_state
    return known and not faces and not any(rests) and not any(e.stamps for e in s.spec.effects)


def _torque_rows(s: Any) -> Array:
    """(nv, c) what one unit of each force component, in contact axes, changes of the torques. Of joints that yield at
    their limits the equations see to it that nothing changes.
    """
    scene, spec = s.scene, s.spec
    mechanism, c, n = spec.mechanism, scene.components, scene.n
    if mechanism is None:
        return np.zeros((0, c))
    effects = tuple([e for e in spec.effects if not isinstance(e, TorqueSaturation)])
    soft = bool(scene.soft)

    def torque(components: Array) -> Array:
        moments = scene.by_contact(components[3 * n :]) if soft else None
        return np.asarray(mechanism.joints(scene, effects, components[: 3 * n].reshape(n, 3), moments, {}).torque)

    still = torque(np.zeros(c))
    return np.array([torque(unit) - still for unit in np.eye(c)]).T


def _factors(argument: str, value: Any) -> tuple[float, float]:
    """(least, largest), with one between them."""
    least, most = array(argument, value, (2,)).tolist()
    if not 0.0 < least <= 1.0 <= most:
        raise InputError(argument, "the least and the largest factor, 0 < least ≤ 1 ≤ largest", repr(value)[:80])
    return least, most
