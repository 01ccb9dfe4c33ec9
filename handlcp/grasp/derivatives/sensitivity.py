"""`Sensitivity`: what changes that a designer could make do to an answer, to first order, in a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_array, check_method_calls, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint
from handlcp.grasp.derivatives.parameter import (
    find_present_parameter,
    parameters,
    parameters_by_effort,
    present_parameters,
)
from handlcp.grasp.derivatives.response import DerivativeKink, ResponseRates, find_kinks, find_rates, free_directions
from handlcp.lazy_property import lazy_property
from handlcp.record import Record, make_data_frame, to_plain
from handlcp.tolerances import ACTIVE_TOLERANCE
from handlcp.words import TextTable, first_largest_index, wrap_text

# Everything of an answer that can be differentiated
QUANTITIES = "forces", "torsion", "torques", "slip", "gap", "displacement", "friction_margin", "torque_margin"
_JOINT_QUANTITIES = "torques", "torque_margin"  # of hands alone


def quantity_rates(answer: LinearisationPoint, rates: ResponseRates, change: LawChange) -> dict[str, Array]:
    """How fast each quantity changes (…, p), from the rates of the response, and of the laws themselves."""
    scene, n, spec = answer.scene, answer.scene.n, answer.spec
    torsion = np.zeros((n, rates.forces.shape[1]))
    torsion[list(scene.soft)] = rates.forces[3 * n :]
    # Past the fingertips; where a prescribed force makes the finger follow, by nothing
    slip = np.where(scene.force_unknown_mask[:, None, None], rates.contact_motion[: 3 * n].reshape(n, 3, -1), 0.0)
    found = {"forces": rates.forces[: 3 * n].reshape(n, 3, -1), "torsion": torsion, "slip": slip[:, :2]}
    found |= {"gap": slip[:, 2], "displacement": rates.object_twist}
    found["friction_margin"] = _friction_margin_rates(answer, rates, change)
    if spec.mechanism is not None:
        torques = np.asarray(answer.torque_rows.T @ rates.forces + change.torque)
        margin = change.torque_limits - np.sign(answer.joints.torque)[:, None] * torques
        has_limit = np.isfinite(spec.mechanism.limits)[:, None]
        found |= {"torques": torques, "torque_margin": np.where(has_limit, margin, np.nan)}
    return found


def _friction_margin_rates(answer: LinearisationPoint, rates: ResponseRates, change: LawChange) -> Array:
    """μ r_N - |r̂_T|, of the exact law; NaN without friction. Without a tangential force any change takes from it."""
    scene, n = answer.scene, answer.scene.n
    lawful, out = rates.forces / answer.scale[:, None], np.full((n, rates.forces.shape[1]), np.nan)
    limits = answer.friction.coefficients
    for i in np.flatnonzero(scene.mu > 0.0).tolist():
        own = [3 * i, 3 * i + 1, *([3 * n + scene.soft.index(i)] if i in scene.soft else [])]
        r, z = answer.law_forces[own], 3 * i + 2
        size = float(np.sqrt(r @ r))
        used = r @ lawful[own] / size if size > answer.force_tolerance else np.sqrt((lawful[own] ** 2).sum(axis=0))
        grows = change.friction[i] * (scene.mu[i] / limits[i] if limits[i] > 0.0 else 0.0)
        out[i] = scene.mu[i] * lawful[z] + grows * answer.law_forces[z] - used
    return out


# ----------------------------------------------------------------

_FORCE_TOLERANCE = 1e-3  # of the largest force
_COLUMN_ROUNDING = 1e-6  # of the largest number in a column


def describe_sensitivity(s: Sensitivity, answer: LinearisationPoint) -> str:
    """Of a `Sensitivity`, and where its derivatives have two sides or none."""
    least, rows = _least_margin_contact(answer), []
    for p in parameters_by_effort():  # those first that take the least effort to change
        if (row := p.shown(answer)) is not None:
            rates = [s.along(p.name, way).ahead for _, way in row.ways]
            forces = max(np.nanmax(abs(rate["forces"]), initial=0.0) for rate in rates)
            if not row.slight or forces > _FORCE_TOLERANCE * abs(answer.forces).max():
                rows.append((row, np.array([_change_effect(rate, answer, least) for rate in rates])))
    rows.sort(key=lambda one: len(one[0].ways) > 1)  # single contacts last
    largest = np.nan_to_num(abs(np.concatenate([effects for _, effects in rows]))).max(axis=0)
    scale, cells = np.where(largest > 0.0, largest, 1.0), []
    for row, each in rows:
        most = first_largest_index((np.nan_to_num(abs(each)) / scale).sum(axis=1))  # all columns count alike
        *signed, moved = np.where(abs(each[most]) < _COLUMN_ROUNDING * scale, 0.0, each[most]).tolist()
        numbers = [*(format_value(x, "+.3g") for x in signed), format_value(moved, ".3g")]
        cells.append((row.text, row.ways[most][0], *numbers))
    torque = ("torque\nN·m",) if "torques" in s.quantities else ()
    heads = ("change", "where", "force\nN", "to spare\nN", *torque, "motion\nmm")
    spare = "no contact sticks with friction to spare"
    if least is not None:
        spare = f"the friction to spare at {answer.spec.names[least]}, of all that stick the nearest to sliding"
    legend = (
        f"Changes of the largest force, {spare}{', the largest torque' if torque else ''}, and how far the object"
        " moves. The last two rows are one contact each, where the change does most."
    )
    lines = [str(TextTable(heads, tuple(cells), "<<" + ">" * (len(heads) - 2))), wrap_text(legend)]
    if kinks := [str(k) for k in s.kinks if not k.by]:  # of these rows
        lines.append(wrap_text(f"Two sides, of which this is one: {'; '.join(kinks)}.", "  "))
    if s.free:
        count = f"{s.free} direction{'s' if s.free > 1 else ''}"
        lines.append(wrap_text(f"Left free in {count}: – is what they change, or a change without an answer.", "  "))
    return "\n".join(lines)


def _change_effect(rate: dict[str, Array], answer: LinearisationPoint, least: int | None) -> list[float]:
    """Of a change on the largest force, the margin of the contact with the least of it, the largest torque and the
    motion, in mm.
    """
    sizes = np.sqrt((answer.forces**2).sum(axis=1))
    i = first_largest_index(sizes)
    found = [float(answer.forces[i] @ rate["forces"][i] / sizes[i]) if sizes[i] > 0.0 else 0.0]
    found.append(np.nan if least is None else float(rate["friction_margin"][least]))
    if "torques" in rate:
        torque = answer.joints.torque
        j = first_largest_index(abs(torque))
        found.append(float(np.sign(torque[j]) * rate["torques"][j]))
    return [*found, 1e3 * float(np.linalg.norm(rate["displacement"][:3]))]


def _least_margin_contact(answer: LinearisationPoint) -> int | None:
    """The contact that presses and sticks with the least margin; None where none does."""
    scene, lawful = answer.scene, answer.law_forces
    margins = np.full(scene.n, np.inf)
    for i in range(scene.n):
        push, own = lawful[3 * i + 2], answer.tangential_components(i)
        spare = scene.mu[i] * push - float(np.sqrt(lawful[own] @ lawful[own]))
        if own and push > answer.force_tolerance and spare > answer.force_tolerance:
            margins[i] = spare
    return first_largest_index(-margins) if np.isfinite(margins).any() else None


def format_value(x: float, form: str) -> str:
    """In this form; – for what is no number."""
    return "–" if not np.isfinite(x) else "0" if x == 0.0 else f"{x:{form}}"


# ----------------------------------------------------------------
# Derivatives of an answer, made when they are asked for.


_REBUILT_PARAMETERS = "posture", "lengths"  # by these the grasp is made again as it was asked for


@dataclass(frozen=True, eq=False)
class DirectionalDerivatives:
    """What an answer does while a parameter moves along a direction: derivatives per unit of it, where it begins to
    grow (`ahead`) and where it begins to shrink (`behind`). Both are the same away from kinks. Each maps a quantity to
    its derivative, in the shape that the quantity has in the solution; NaN: there is no answer on that side.
    """

    ahead: dict[str, Array]
    behind: dict[str, Array]


@check_method_calls
class Sensitivity(Record):
    """Derivatives of a solution, `<quantity>_by_<parameter>`: read-only arrays in the shape of the quantity followed by
    that of the parameter, SI. Made by `solution.sensitivity()`.

    Quantities: forces (n, 3) contact axes, torsion (n,) of soft fingers, slip (n, 2), gap (n,), displacement (6,) about
    the reference, friction_margin (n,); of a hand torques (nv,), torque_margin (nv,).
    Parameters: wrench (6,) about the reference, squeeze (n,) [m], pads (n,) [m/N], friction (n,) the coefficient, with
    which the law grows as a whole, positions (n, 3) [m] world axes, normals (n, 3) turns of the contact axes about
    themselves [rad]; of a hand stiffness (nv,) [N·m/rad], joint_offset (nv,) [rad], torque_limits (nv,) [N·m], which
    matter beside `TorqueSaturation`, posture (nv,) [rad], lengths (m, 3) [m] of `length_names`.

    One parameter changes and all else stays: contacts, offsets and commands of the joints stay as they are while
    contacts move or turn. By posture and lengths the grasp is made again as it was asked for: contacts on an object are
    detected anew, those that were given stay, and so do the arguments squeeze, grip_force and joint_offset. (These two
    are central differences of what is detected, not of answers.)

    Contacts keep their states. Where a state depends on the direction of a change, `kinks` says which, and each entry
    is the derivative for a parameter that grows; `along` has both sides. By posture and lengths alone, a fingertip that
    just touches the object it was detected on is such a kink: what is deeper counts as squeezed as `close_on` squeezes,
    with the sideways motion of the tip, and a gap does not. NaN: not determined, because the solution leaves it free,
    or no answer lies in that direction.
    """

    def __init__(self, answer: LinearisationPoint) -> None:
        self._answer = answer
        self._rates: dict[str, tuple[dict[str, Array], LawChange]] = {}

    @property
    def parameters(self) -> tuple[str, ...]:
        """What there are derivatives by."""
        return tuple([p.name for p in present_parameters(self._answer.spec)])

    @property
    def quantities(self) -> tuple[str, ...]:
        """What there are derivatives of."""
        hand = self._answer.spec.mechanism is not None
        return tuple([name for name in QUANTITIES if hand or name not in _JOINT_QUANTITIES])

    @property
    def length_names(self) -> tuple[str, ...]:
        """(m,) joints and fingertips whose places are `lengths`; () without a hand."""
        mechanism = self._answer.spec.mechanism
        return () if mechanism is None else mechanism.variation.lengths

    @lazy_property
    def _kinks(self) -> tuple[DerivativeKink, ...]:
        """Where derivatives by any parameter have two sides."""
        return find_kinks(self._answer)

    @property
    def kinks(self) -> tuple[DerivativeKink, ...]:
        """Where a derivative has two sides; () where nothing does."""
        names, tips = self._answer.spec.names, self._answer.tip_depths
        what, touching = "just touches where it was detected", tips.contacts[tips.touch].tolist()
        return (*self._kinks, *(DerivativeKink(names[i], what, i, _REBUILT_PARAMETERS) for i in touching))

    @property
    def free(self) -> int:
        """In how many directions forces and motion are free, so that derivatives along them are NaN."""
        return int(free_directions(self._answer).shape[1])

    def of(self, quantity: str, parameter: str) -> Array:
        """The derivative, as the attribute `<quantity>_by_<parameter>`. Raises UnknownName, and Unsupported where a
        grasp has no such derivative.
        """
        if quantity not in self.quantities:
            raise UnknownName("quantity", "a quantity", [str(quantity)], self.quantities)
        found = self._rates_by(parameter)[0][quantity]
        return read_only(found.reshape(*found.shape[:-1], *self._shape(parameter)))

    def along(self, parameter: str, direction: Any) -> DirectionalDerivatives:
        """The derivatives along a direction, an array in the parameter's shape, on both sides. Raises UnknownName,
        InputError.
        """
        _, change = self._rates_by(parameter)
        way = check_array("direction", direction, self._shape(parameter)).reshape(-1)
        ahead, behind = (self._ahead(change.along(direction)) for direction in (way, -way))
        return DirectionalDerivatives(
            {name: read_only(ahead[name][..., 0]) for name in self.quantities},
            {name: read_only(-behind[name][..., 0]) for name in self.quantities},
        )

    def _shape(self, parameter: str) -> tuple[int, ...]:
        return find_present_parameter(self._answer.spec, parameter).shape(self._answer.spec)

    def _ahead(self, change: LawChange) -> dict[str, Array]:
        return quantity_rates(self._answer, find_rates(self._answer, self._kinks, change), change)

    def _rates_by(self, parameter: str) -> tuple[dict[str, Array], LawChange]:
        if parameter not in self._rates:
            change = find_present_parameter(self._answer.spec, parameter).change(self._answer)
            self._rates[parameter] = self._ahead(change.ahead), change
        return self._rates[parameter]

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, by name: nested lists, SI, None for what is not a finite number; and the kinks."""
        found: dict[str, Any] = {"kinks": [str(k) for k in self.kinks], "free_directions": self.free}
        return found | {f"{q}_by_{p}": to_plain(self.of(q, p)) for p in self.parameters for q in self.quantities}

    def to_frame(self, quantity: str, parameter: str) -> Any:
        """A pandas table of one derivative: a row for each entry of the quantity, a column for each of the parameter,
        both named by their numbers, such as "0.2". Raises UnknownName, and Unsupported without pandas.
        """
        value = self.of(quantity, parameter)
        of = self._shape(parameter)
        rows, columns = value.shape[: value.ndim - len(of)], [".".join(map(str, k)) for k in np.ndindex(*of)]
        flat = value.reshape(-1, len(columns))
        index = [".".join(map(str, k)) for k in np.ndindex(*rows)]
        return make_data_frame({name: flat[:, k] for k, name in enumerate(columns)}, index)

    def __str__(self) -> str:
        """What the change in each row, such as 10 % less friction at all fingers, does to the largest force, the
        friction to spare, the largest torque, and the motion.
        """
        return describe_sensitivity(self, self._answer)

    def __getattr__(self, name: str) -> Array:
        """Return the derivative that `<quantity>_by_<parameter>` names."""
        quantity, by, parameter = name.partition("_by_")
        if not by or quantity not in QUANTITIES or all(p.name != parameter for p in parameters()):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        value = self.of(quantity, parameter)
        self.__dict__[name] = value
        return value

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(f"{q}_by_{p}" for q in self.quantities for p in self.parameters)]


def make_sensitivity(solution: Any) -> Sensitivity:
    """Linearise a `GraspSolution` for its derivatives. Raises InputError for one that is not held, and so has no
    forces.
    """
    s = solution
    if not s.held or s.spec is None or s.scene is None or s.section is None:
        raise InputError("solution", "a solution that is held: others have no forces", s.status.name)
    weak = ACTIVE_TOLERANCE * s.residuals.force_scale
    slow = ACTIVE_TOLERANCE * max(s.residuals.motion_scale, s.scene.units.motion_unit)
    twist = s.object_displacement
    return Sensitivity(LinearisationPoint(s.spec, s.scene, s.section, s.forces, s.torsion, twist, s.extra, weak, slow))
