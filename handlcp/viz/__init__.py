"""What people look at: tables, pictures, records. The only place that imports matplotlib, and only when it draws.

Results of other rooms take the functions listed beside this file (`__init__.pyi`) when somebody asks to see them.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
