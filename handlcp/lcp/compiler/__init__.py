"""When kernels are compiled, and where compiled code is kept. Knows no mathematics.

numba is imported by `dispatch`, when something is to be compiled or loaded.
"""
