"""How fast the hot paths are, as ratios taken in one run: `make bench`.

Machines are noisy and differ, so no time is judged alone: each hot path stands beside the least
that its data demand (a copy of them, or the drawing of their random numbers).
"""

from collections.abc import Callable
from statistics import median
from time import perf_counter

import numpy as np

from cmtof.baselines.kde import kde, kde_by_double_loop
from cmtof.correlation import TAU, decode
from cmtof.scenes import Frame
from cmtof.simulation import simulate

SHAPE = (768, 1024)
PSI = np.tile(np.arange(4) * np.pi / 2, (2, 1))


def seconds(work: Callable[[], object], repeats: int = 15) -> float:
    """Median time of a call, once caches and the memory allocator have settled."""
    for _ in range(repeats // 3):
        work()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return median(times)


def decode_by_fft(stack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase and amplitude the textbook way: numpy.fft along psi, its angle and modulus."""
    first = np.fft.fft(stack, axis=1)[:, 1]
    return np.angle(first) % TAU, 2 * np.abs(first) / stack.shape[1]


def line(what: str, ratio: float, goal: str, bound: str) -> None:
    """Print one ratio with its goal and what limits it."""
    print(f"{what:<58} {ratio:7.2f} x   goal {goal:<8} near the bound of {bound}")


def main() -> None:
    """Print every ratio."""
    rng = np.random.default_rng(0)
    y, x = np.indices(SHAPE)
    frame = Frame(1 + 3 * (x + y) / sum(SHAPE), rng.uniform(0.05, 1, SHAPE))
    stack = simulate(frame, protocol="full", seed=0).dataset["correlation"].to_numpy()

    fast = seconds(lambda: decode(stack, PSI))
    line("decode (2, 4, 768, 1024) float32 / copy", fast / seconds(stack.copy), "< 4", "memory")
    by_fft = seconds(lambda: decode_by_fft(stack), 3)
    line("numpy.fft to phase and amplitude / decode", by_fft / fast, "> 20", "memory")
    transform = seconds(lambda: np.fft.fft(stack, axis=1), 5)
    line("numpy.fft alone / decode", transform / fast, "", "memory")

    mean = simulate(frame, protocol="full", noise_free=True).dataset["correlation"].to_numpy()

    def draw() -> None:
        rng.poisson(mean)
        rng.standard_normal(mean.shape, dtype=np.float32)

    whole = seconds(lambda: simulate(frame, protocol="full", seed=0), 3)
    line("simulate / drawing its random numbers", whole / seconds(draw, 3), "< 1.5", "arithmetic")

    small = simulate(
        Frame(frame.depth[::6, ::8], frame.intensity[::6, ::8]), protocol="full", seed=0
    )
    small = small.between(1.0, 1.44)
    _ = small.decoded
    looped = seconds(lambda: kde_by_double_loop(small), 1)
    line("kde by its double loop / kde, 128x128", looped / seconds(lambda: kde(small), 3),
         "> 20", "arithmetic")  # fmt: skip


if __name__ == "__main__":
    main()
