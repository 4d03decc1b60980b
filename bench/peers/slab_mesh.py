#!/usr/bin/env python3
"""Writes the slab's structured mesh for GetDP (msh 2.2): slab_mesh.py N FILE.

Physical groups: 1 body, 2 right side, 3 roof, 4 ground nodes between the ends, 5 the two ends.
The ground is a set of points, since GetDP has no trapezoidal rule on lines.
"""
import sys


def main(n, file):
    across = 2 * n + 1
    node = lambda i, j: 1 + j * across + i
    elements = []
    for j in range(n):
        for i in range(2 * n):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            elements += [(2, 1, a, b, c), (2, 1, a, c, d)]
    elements += [(1, 2, node(2 * n, j), node(2 * n, j + 1)) for j in range(n)]
    elements += [(1, 3, node(i, n), node(i + 1, n)) for i in range(2 * n)]
    elements += [(15, 4 if 0 < i < 2 * n else 5, node(i, 0)) for i in range(across)]
    with open(file, "w") as out:
        print(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{across * (n + 1)}", file=out)
        for j in range(n + 1):
            for i in range(across):
                print(node(i, j), repr(i / n), repr(j / n), 0, file=out)
        print(f"$EndNodes\n$Elements\n{len(elements)}", file=out)
        for number, (kind, group, *nodes) in enumerate(elements, 1):
            print(number, kind, 2, group, group, *nodes, file=out)
        print("$EndElements", file=out)


main(int(sys.argv[1]), sys.argv[2])
