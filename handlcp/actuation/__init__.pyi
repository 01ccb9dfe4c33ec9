from .measured_stiffness import MeasuredStiffness as MeasuredStiffness, stiffness_from as stiffness_from
from .motor import Motor as Motor
from .route import Around as Around, Pulley as Pulley, Route as Route, Site as Site
from .transmission import Synergies as Synergies, Tendons as Tendons
