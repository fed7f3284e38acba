"""The sparsity pattern of the tangent, laid out once per model: upper triangle of 3 x 3 node blocks in CSR."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Pattern:
    """Upper-triangular CSR pattern: indptr (3 N + 1,), indices (nnz,), sorted, every diagonal entry present.

    rows (3 N,): position of the diagonal entry of each row; pairs: per contribution (n, k (k - 1) / 2, 3) positions of
    the first entry in the three rows of each off-diagonal block; adjacency: node graph for orderings.
    """

    size: int
    indptr: IntArray
    indices: IntArray
    rows: IntArray
    pairs: tuple[IntArray, ...]
    adjacency: sparse.csr_array

    @cached_property
    def neighbours(self) -> sparse.csr_array:
        """Symmetric node graph with ones, every node its own neighbour."""
        graph = (self.adjacency + self.adjacency.T).tocsr()
        graph.data[:] = 1.0
        return graph

    def matrix(self, values: Array) -> sparse.csr_array:
        """Return the upper triangle with these values as a sparse matrix."""
        return sparse.csr_array((values, self.indices, self.indptr), shape=(self.size, self.size))


def lay_out(node_count: int, elements: list[IntArray]) -> Pattern:
    """Lay the pattern out for elements given as node tuples (n, k), each coupling all of its nodes."""
    ends = [_pair_nodes(nodes) for nodes in elements]
    low = np.concatenate([np.arange(node_count)] + [pair.min(axis=-1).ravel() for pair in ends])
    high = np.concatenate([np.arange(node_count)] + [pair.max(axis=-1).ravel() for pair in ends])
    graph = sparse.coo_array((np.ones(len(low)), (low, high)), shape=(node_count, node_count)).tocsr()
    graph.sort_indices()
    first, neighbour = graph.indptr.astype(np.int64), graph.indices.astype(np.int64)
    blocks = np.diff(first)
    # Row r of a node has 3 - r entries of its own block and 3 for each neighbour with a higher number.
    row_length = (3 * blocks[:, None] - np.arange(3)).ravel()
    indptr = np.concatenate([[0], np.cumsum(row_length)])
    rows = indptr[:-1].copy()
    indices = np.empty(indptr[-1], dtype=np.int64)
    owner = np.repeat(np.arange(node_count), blocks)
    slot = np.arange(len(neighbour)) - first[owner]
    for r in range(3):
        base = indptr[3 * owner + r] + 3 * slot - r
        for c in range(3):
            keep = (slot > 0) | (c >= r)
            indices[(base + c)[keep]] = (3 * neighbour + c)[keep]
    key = owner * node_count + neighbour
    pairs = tuple(_locate(pair, key, slot, indptr, node_count) for pair in ends)
    return Pattern(3 * node_count, indptr, indices, rows, pairs, graph)


def _pair_nodes(nodes: IntArray) -> IntArray:
    """Return the node pairs (n, k (k - 1) / 2, 2) of elements (n, k)."""
    a, b = np.triu_indices(nodes.shape[1], 1)
    return np.stack([nodes[:, a], nodes[:, b]], axis=-1).astype(np.int64)


def _locate(pair: IntArray, key: IntArray, slot: IntArray, indptr: IntArray, node_count: int) -> IntArray:
    low, high = pair.min(axis=-1), pair.max(axis=-1)
    place = slot[np.searchsorted(key, low * node_count + high)]
    return np.stack([indptr[3 * low + r] + 3 * place - r for r in range(3)], axis=-1)
