r"""Linear-Gaussian algebra behind all stages: everything a hypothesis needs is a scalar product of whitened vectors.

With covariance C = L L^T of the measurement (noise, specimen scatter, numerical error, base parameters within their
coupons' covariance) a vector v is whitened to L^-1 v. For a hypothesis that predicts the mean change d and further
Gaussian freedom H H^T (columns h_j, prior variance one)

    log p(r) = -1/2 [ |r - d|^2 - g^T (I + G)^-1 g + log det(I + G) ] + log p_0,   G = H^T H,  g = H^T (r - d)

in whitened vectors, log p_0 = -1/2 (log det C + n log 2 pi) being common to all hypotheses. So after one Cholesky
factorisation thousands of parameter values are judged by small matrices only (Woodbury's identity).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.types import Array


@dataclass(frozen=True)
class Whitener:
    """Cholesky factor (n, n) of a covariance."""

    factor: Array

    @classmethod
    def of(cls, covariance: Array) -> Whitener:
        """Factorise a covariance (n, n); a relative 1e-10 on the diagonal keeps it definite."""
        jitter = 1e-10 * float(np.mean(np.diag(covariance)))
        return cls(np.asarray(np.linalg.cholesky(covariance + jitter * np.eye(len(covariance))), dtype=float))

    def __call__(self, vectors: Array) -> Array:
        """Return whitened vectors (n,) or (n, k)."""
        from scipy.linalg import solve_triangular

        return np.asarray(solve_triangular(self.factor, vectors, lower=True))

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the covariance."""
        return 2.0 * float(np.log(np.diag(self.factor)).sum())


def log_evidence(columns: Array) -> Array:
    """Return log p(r) - log p_0 (b,) for a batch of hypotheses.

    columns (b, k + 1, n): the whitened columns of H, and r - d as the last row. Both terms stand on the diagonal of one
    Cholesky factor, that of the Gram matrix of all rows plus the identity: its last pivot is 1 + |r - d|^2 - g^T (I +
    G)^-1 g, the others multiply to det(I + G).
    """
    gram = np.matmul(columns, columns.transpose(0, 2, 1))
    diagonal = np.arange(gram.shape[-1])
    gram[:, diagonal, diagonal] += 1.0
    pivots = np.diagonal(np.linalg.cholesky(gram), axis1=1, axis2=2)
    return np.asarray(-0.5 * (pivots[:, -1] ** 2 - 1.0) - np.log(pivots[:, :-1]).sum(axis=1))


def log_sum(values: Array, axis: int | None = None) -> Array:
    """Return log sum exp over an axis without overflow."""
    top = np.max(values, axis=axis, keepdims=True)
    finite = np.where(np.isfinite(top), top, 0.0)
    total = np.exp(values - finite).sum(axis=axis, keepdims=True)
    total = np.where(total > 0.0, np.log(np.where(total > 0.0, total, 1.0)) + finite, -np.inf)
    return np.asarray(total.reshape(()) if axis is None else np.squeeze(total, axis=axis))


def smooth_modes(covariance: Array, *, share: float = 0.995, most: int = 40) -> Array:
    """Return columns (n, k) with covariance = sum of their outer products but for 1 - share of its trace."""
    values, vectors = np.linalg.eigh(covariance)
    order = np.argsort(values)[::-1]
    values, vectors = np.maximum(values[order], 0.0), vectors[:, order]
    if values.sum() <= 0.0:
        return np.zeros((len(covariance), 0))
    keep = int(np.searchsorted(np.cumsum(values) / values.sum(), share)) + 1
    keep = min(keep, most, len(values))
    return np.asarray(vectors[:, :keep] * np.sqrt(values[:keep]))
