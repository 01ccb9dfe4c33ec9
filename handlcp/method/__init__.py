"""Studies of the method and of the paper it comes from: what accuracy costs, how fast it converges, what effects cost.

Nobody who designs hands needs them: nothing but commands imports this room.
"""
