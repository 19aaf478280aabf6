"""A command of a stranger's."""


def greet(name: str, *, loud: bool = False) -> None:
    """Greet somebody.

    Parameters
    ----------
    name : Who is greeted.
    loud : With a voice that carries.
    """
    print(f"Good morning, {name.upper() if loud else name}")
