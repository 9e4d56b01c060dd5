"""Parts of one work on several threads."""

from __future__ import annotations

import threading
import time

import pytest

from surfaces.numerics import parallel


@pytest.mark.parametrize("count", [0, 1, 2, 9])
def test_results_of_unequal_parts_come_in_their_order(count):
    def square(part: int) -> int:
        time.sleep(0.02 if part == 1 else 0.001)
        return part**2

    assert parallel.each(square, range(count)) == [part**2 for part in range(count)]


def test_one_thread_is_one_thread():
    names: list[str] = []
    try:
        parallel.set_threads(1)
        parallel.each(lambda _: names.append(threading.current_thread().name), range(3))
    finally:
        parallel.set_threads(None)
    assert names == [threading.current_thread().name] * 3


def test_parts_apart_have_one_thread_each_all_the_way_down():
    def inside(part: int) -> tuple[int, int, bool]:
        here = threading.current_thread().name
        below = parallel.each(lambda _: threading.current_thread().name, range(3))
        return part, parallel.threads(), below == [here] * 3

    try:
        parallel.set_threads(2)
        assert parallel.apart(inside, range(4)) == [(part, 1, True) for part in range(4)]
        within = parallel.apart(lambda _: parallel.apart(inside, range(2)), range(2))
        assert within == [[(part, 1, True) for part in range(2)]] * 2
        # one part by itself, and what comes after, have all of them
        assert parallel.apart(inside, [7])[0][1] == min(2, parallel.available())
        assert parallel.threads() == min(2, parallel.available())
    finally:
        parallel.set_threads(None)


def test_what_fails_apart_fails_for_the_caller():
    def broken(part: int) -> None:
        if part:
            raise ValueError("part 1")

    before = parallel.threads()
    with pytest.raises(ValueError, match="part 1"):
        parallel.apart(broken, range(2))
    assert parallel.threads() == before


@pytest.mark.parametrize("count", [1, 2])
def test_what_runs_beside_parts_has_all_threads_and_is_called_here(count):
    seen: list[tuple[str, int]] = []

    def beside() -> None:
        seen.append((threading.current_thread().name, parallel.threads()))

    try:
        parallel.set_threads(count)
        assert parallel.apart(lambda part: (part, parallel.threads()), range(3), beside) == [
            (part, 1) for part in range(3)
        ]
    finally:
        parallel.set_threads(None)
    assert seen == [(threading.current_thread().name, min(count, parallel.available()))]


def test_of_interrupted_work_the_rest_is_not_begun():
    begun: list[int] = []

    def part(number: int) -> None:
        if number == 0:
            raise KeyboardInterrupt
        begun.append(number)
        time.sleep(0.01)

    with pytest.raises(KeyboardInterrupt):
        parallel.each(part, range(20))
    time.sleep(0.2)
    assert len(begun) <= 2 * parallel.available()
