from .object import Object as Object
from .shape import YCB as YCB, Box as Box, Cylinder as Cylinder, Ellipsoid as Ellipsoid, Mesh as Mesh, Sphere as Sphere
from .table import Table as Table
