"""Mutations that fuzzers of files share: of text, or of bytes."""


def mutated(rng, data, mutations):
    """It with one to three of these mutations, while anything is left to mutate; and the names of these."""
    done = list[str]()
    for _ in range(rng.choice([1, 1, 2, 3])):
        mutate = rng.choice(mutations)
        try:
            data = mutate(rng, data)
        except (IndexError, ValueError, SyntaxError):  # nothing left, or no XML any more
            break
        done.append(mutate.__name__)
    return data, done


def truncated(rng, data):
    return data[: rng.randrange(len(data))]


def with_one_of(rng, data, marks):
    i = rng.randrange(len(data))
    return data[:i] + rng.choice(marks) + data[i:]


def _lines(data):
    """The lines, and what joins them."""
    return (data.split(b"\n"), b"\n") if isinstance(data, bytes) else (data.splitlines(), "\n")


def no_line(rng, data):
    lines, end = _lines(data)
    del lines[rng.randrange(len(lines))]
    return end.join(lines)


def line_moved(rng, data):
    lines, end = _lines(data)
    lines.insert(rng.randrange(len(lines)), lines.pop(rng.randrange(len(lines))))
    return end.join(lines)


def line_twice(rng, data):
    lines, end = _lines(data)
    lines.insert(rng.randrange(len(lines)), rng.choice(lines))
    return end.join(lines)
