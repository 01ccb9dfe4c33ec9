"""A page that one can turn: hand, object, forces and verdict in one HTML file, with the loading as a slider."""
