from .accuracy.figure import draw_path_cost as draw_path_cost
from .envelope.figure import draw_envelope as draw_envelope, draw_polar_envelope as draw_polar_envelope
from .envelope.page import write_envelope_page as write_envelope_page
from .load_limit_figure import draw_limit as draw_limit
from .loading.figure import draw_loading as draw_loading, plot_solution as plot_solution
from .output_file import draw_or_save as draw_or_save
from .page.document import write_loading_page as write_loading_page, write_solution_page as write_solution_page
from .reliability_figure import draw_reliability as draw_reliability
from .solution_output import (
    solution_html as solution_html,
    solution_to_dict as solution_to_dict,
    table_html as table_html,
)
from .strength_figure import draw_payload as draw_payload, draw_split_cylinder as draw_split_cylinder
from .study.figure import draw_study as draw_study
from .study.page import write_study_page as write_study_page
from .terminal_table import torque_table as torque_table
