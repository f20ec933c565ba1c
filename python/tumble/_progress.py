"""Progress of long calls: a function of yours, or a bar of tqdm."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tumble._errors import wrong_type
from tumble._text import need

Call = Callable[[float, str], object]


@contextmanager
def listener(progress: object) -> Iterator[Call | None]:
    """The function that the library calls with (done from 0 to 1, what).

    Given     progress  None or False: nothing; True: a bar of tqdm, in a notebook a widget; else a function
    Raises    ArgumentTypeError; UsageError where tqdm is absent
    """
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = need("tqdm.auto", "progress").tqdm(total=100, unit="%", leave=False)

        def show(done: float, what: str) -> None:
            bar.set_description(what)
            bar.update(round(100 * done) - bar.n)

        try:
            yield show
        finally:
            bar.close()
    elif callable(progress):
        yield progress
    else:
        raise wrong_type("progress", progress, "accepted are None, True, and a function of (done, what)")
