"""Fixed-step Runge-Kutta methods, as tables of numbers and one function that works on floats and on symbols."""
from collections.abc import Callable
from types import ModuleType
from typing import Any

# Order -> (stages, weights). A stage is (node, weights of the slopes before it): its slope is taken at the step's start
# plus node times the step.
METHODS: dict[int, tuple[tuple[tuple[float, tuple[float, ...]], ...], tuple[float, ...]]] = {
    1: (((0, ()),), (1,)),                                                         # Euler
    2: (((0, ()), (1 / 2, (1 / 2,))), (0, 1)),                                     # the midpoint rule
    4: (((0, ()), (1 / 2, (1 / 2,)), (1 / 2, (0, 1 / 2)), (1, (0, 0, 1))),         # the classical one
        (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
    6: (((0, ()),                                                                  # Butcher, J. Austral. Math. Soc. 4
         (1 / 3, (1 / 3,)),                                                        # (1964), in seven stages
         (2 / 3, (0, 2 / 3)),
         (1 / 3, (1 / 12, 1 / 3, -1 / 12)),
         (1 / 2, (-1 / 16, 9 / 8, -3 / 16, -3 / 8)),
         (1 / 2, (0, 9 / 8, -3 / 8, -3 / 4, 1 / 2)),
         (1, (9 / 44, -9 / 11, 63 / 44, 18 / 11, 0, -16 / 11))),
        (11 / 120, 0, 27 / 40, 27 / 40, -4 / 15, -4 / 15, 11 / 120)),
}
USUAL_ORDER = 4


def integrate(rate: Callable[[Any, list[Any]], list[Any]], t: Any, x: list[Any], h: Any, order: int) -> list[Any]:
    """The state h seconds after `t`, by one step of the method of this order: rate(t, x) gives dx/dt, a list as long
    as x. `order` is one of METHODS."""
    stages, weights = METHODS[order]
    slopes: list[list[Any]] = []
    for node, earlier in stages:
        slopes.append(rate(t + h * node if node else t, moved(x, h, earlier, slopes)))
    return moved(x, h, weights, slopes)


def moved(x: list[Any], h: Any, weights: tuple[float, ...], slopes: list[list[Any]]) -> list[Any]:
    """x + h sum(weight * slope), leaving out the slopes of no weight."""
    for weight, slope in zip(weights, slopes):
        if weight:
            factor = h * weight
            x = [a + factor * k for a, k in zip(x, slope)]
    return x


def advancing(model: ModuleType) -> Callable[..., list[Any]]:
    """The `advance` of a model: its own, or one that integrates its `derivative` with the method of its ORDER, or, of
    a model that has neither, one that changes nothing."""
    own: Callable[..., list[Any]] | None = getattr(model, "advance", None)
    if own or not hasattr(model, "derivative"):
        return own or (lambda m, t, h, x, u, p, c: x)
    derivative, count, order = model.derivative, len(model.STATES), getattr(model, "ORDER", USUAL_ORDER)

    def advance(m: Any, t: Any, h: Any, x: list[Any], u: Any, p: Any, c: list[Any]) -> list[Any]:
        """One step of h seconds with the inputs held; what `derivative` does not cover stays as it is."""
        return integrate(lambda t, states: derivative(m, t, [*states, *x[count:]], u, p), t, x[:count], h, order) \
            + x[count:]

    return advance
