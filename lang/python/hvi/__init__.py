"""History-dependent hemivariational inequalities from Python: scripts of hvi-run, solved with a certificate for each step.

    import hvi
    result = hvi.load("slab.hvi").run(n=32)
    result["reaction"]          # a column of the table, an array
    result.fields["u"]          # at result.points: (nodes, components)
    result.certificate

See docs/python.md.
"""
from ._errors import Diagnostic, Error, ScriptError, SolveError
from ._fit import Fit, fit
from ._hvi import version as __version__
from ._model import Check, Model, Parameter, Step, Steps, load, loads
from ._result import Grid, Result
from ._sweep import Sweep, sweep

__all__ = ["Check", "Diagnostic", "Error", "Fit", "Grid", "Model", "Parameter", "Result", "ScriptError", "SolveError", "Step", "Steps",
           "Sweep", "fit", "load", "loads", "sweep", "__version__"]
