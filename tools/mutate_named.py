"""Faults that once passed the whole suite: `tools/mutate --named` puts each of them in and wants it killed.

Each is (name, file, text that stands in it exactly once, what to write instead, form of mutate_sites.Site).
"""
NAMED = [
    ("the snap of the inclusion check a thousand times wider", "solver/inequality/certificate.cpp",
     "snap_factor = certificate_snap", "snap_factor = 1e3 * certificate_snap", "expression"),
    ("panels of adaptive quadrature at 2e-7", "solver/history/quadrature.hpp", "2e-12 * panel.magnitude[m]",
     "2e-7 * panel.magnitude[m]", "expression"),
    ("panels of the kernel's quadrature at 2e-7", "solver/history/past_weights.cpp", "2e-12 * magnitude", "2e-7 * magnitude",
     "expression"),
    ("a fingerprint without the values of tables", "solver/time/checkpoint.cpp",
     "for (const double x : table.abscissae()) hash_.add_number(table.value(x))", "", "statement"),
    ("a file that is not on the disk", "solver/output/file.cpp", "::fsync(descriptor_) == 0", "true", "expression"),
    ("a name that is not on the disk", "solver/output/file.cpp", "::fsync(descriptor) == 0 || errno == EINVAL", "true",
     "expression"),
    ("a checkpoint written as any other file", "solver/time/checkpoint.cpp", "write_atomically(path, bytes, Durability::synced)",
     "write_atomically(path, bytes, Durability::ordinary)", "expression"),
    ("memories of a run start at 0", "solver/discrete/memory.cpp", "history->start(t0, view(u0))", "history->start(0.0, view(u0))",
     "expression"),
    ("memories start at 0", "solver/history/steps.hpp", "t0, t0, 0, 0, 1", "0, 0, 0, 0, 1", "list"),
    ("the friction secant not clamped", "solver/inequality/points.cpp", "std::min(s / hit.z, q.penalty)", "s / hit.z",
     "expression"),
]
