"""Meshes of families that compute with finite elements of their own: lattices of simplices whose inner nodes are moved."""
import numpy


def lattice(r, dim, n):
    """Nodes and cells of a unit cube whose inner nodes are moved at random."""
    sides = [range(n + 1)] * dim
    nodes = [tuple(p) for p in numpy.stack(numpy.meshgrid(*sides, indexing="ij"), -1).reshape(-1, dim)]
    number = {p: i for i, p in enumerate(nodes)}
    cells = []
    for corner in nodes:
        if max(corner) == n:
            continue
        orders = {1: [(0,)], 2: [(0, 1), (1, 0)], 3: [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]}[dim]
        for order in orders:
            at, cell = list(corner), [number[corner]]
            for axis in order:
                at[axis] += 1
                cell.append(number[tuple(at)])
            cells.append(cell)
    x = numpy.array(nodes, float) / n
    for i in range(len(x)):
        for axis in range(dim):
            if 0.01 < x[i, axis] < 0.99:
                x[i, axis] += r.uniform(-0.2, 0.2) / n
    for cell in cells:
        if numpy.linalg.det(x[cell[1:]] - x[cell[0]]) < 0:
            cell[-1], cell[-2] = cell[-2], cell[-1]
    return x, cells


def facets_on(cells, nodes, dim):
    """Each with its cell."""
    found = [([n for n in c if n in nodes], k) for k, c in enumerate(cells)]
    return [(f, k) for f, k in found if len(f) == dim]


def msh(x, cells, groups):
    """Gmsh's format 2.2: group 1 is the body, `all`; `groups` have the nodes of facets by name."""
    dim = x.shape[1]
    of_cell, of_facet = {1: (1, 15), 2: (2, 1), 3: (4, 2)}[dim]
    elements = [(of_facet, 2 + g, f) for g, nodes in enumerate(groups.values()) for f, _ in facets_on(cells, nodes, dim)]
    elements += [(of_cell, 1, c) for c in cells]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(1 + len(groups)), f'{dim} 1 "all"']
    lines += [f'{dim - 1} {2 + g} "{name}"' for g, name in enumerate(groups)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(x))]
    lines += [f"{i + 1} " + " ".join(repr(float(v)) for v in [*p, *[0.0] * (3 - dim)]) for i, p in enumerate(x)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{i + 1} {kind} 2 {group} {group} " + " ".join(str(n + 1) for n in part) for i, (kind, group, part) in enumerate(elements)]
    return "\n".join([*lines, "$EndElements", ""])
