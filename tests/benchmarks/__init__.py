"""What the solvers cost and how often they answer, beside other people's. Run on demand, never part of the tests."""
