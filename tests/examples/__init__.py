"""The examples, run as they stand, each with a physical number that has to come out."""
