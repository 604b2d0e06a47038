"""Muon: an optimiser that orthogonalises the momentum of kernels (Jordan et al. 2024)."""

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor

# Share of the old momentum that stays in a step.
MOMENTUM = 0.95


class Muon(torch.optim.AdamW):
    """AdamW, but groups with ``orthogonal`` are updated by their orthogonalised momentum.

    Steps are scaled as large as AdamW's are, so that one learning rate fits both (Liu et al. 2025).
    """

    def step(self, closure: Callable[[], Any] | None = None) -> Any:
        """One step; the closure evaluates loss and gradients."""
        loss = closure and closure()
        for group in self.param_groups:
            if group.get("orthogonal"):
                for kernel in group["params"]:
                    self._update_kernel(kernel, group["lr"], group["weight_decay"])
        super().step()  # skips parameters without a gradient
        return loss

    @torch.no_grad()
    def _update_kernel(self, kernel: Tensor, rate: float, decay: float) -> None:
        """Update a kernel by its orthogonalised momentum, and clear its gradient."""
        state = self.state[kernel]
        if not state:
            # AdamW asks for a step when a checkpoint is loaded
            state.update(momentum=torch.zeros_like(kernel), step=torch.tensor(0.0))
        state["momentum"].lerp_(kernel.grad, 1 - MOMENTUM)
        ahead = kernel.grad.lerp(state["momentum"], MOMENTUM)  # pyright: ignore[reportOptionalMemberAccess]
        direction = orthogonal(ahead.flatten(1)).view_as(kernel)
        size = max(kernel.shape[0], kernel[0].numel())
        kernel.mul_(1 - rate * decay).sub_(direction, alpha=0.2 * size**0.5 * rate)
        kernel.grad = None


def orthogonal(matrix: Tensor) -> Tensor:
    """Approximation of the nearest orthogonal matrix by five quintic Newton-Schulz steps.

    Singular values of one tenth to one of the largest become 0.7 to 1.2.
    """
    if matrix.shape[0] > matrix.shape[1]:
        return orthogonal(matrix.T).T
    x = matrix / (matrix.norm() + 1e-7)
    for _ in range(5):
        square = x @ x.T
        x = 3.4445 * x + (-4.775 * square + 2.0315 * square @ square) @ x
    return x
