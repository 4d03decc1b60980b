"""Scripts with units: right ones give what the same script gives in plain numbers, wrong ones are told with code and place.

usage: units.py HVI_RUN
The base script has units of mm, N, s. A right case replaces texts of it, with units and in plain numbers; both are run and compared. A
wrong case replaces one text and says which words the error underlines. Then random expressions with random units: a dimension
calculator in Python, which knows nothing of the program's, says for each what unit and number it is, or that it is none.
"""
import fractions
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
FOLDER = tempfile.TemporaryDirectory()
WORK = pathlib.Path(FOLDER.name)
failures = []

BASE = """units mm, N, s
import contact
import friction
import materials
import loads
import states
param E = 70 [GPa] in [10, 300] [GPa] "Young's modulus"
param nu = 0.3
param load = 2 [MPa]
param n = 2
mesh slab = rectangle(20 [mm], 10 [mm], cells = [2*n, n])
part left = slab.left
part ground = slab.bottom
part roof = slab.top
part middle = slab where x > 5 [mm] and x < 15 [mm]
tensor B = isotropic(young = E, poisson = nu)
tensor A = isotropic(lambda = 5 [GPa*s], mu = 9 [GPa*s])
kernel C(lag) = -0.25/(3 [s])*exp(-lag/(3 [s]))*B
fn grow(a) = a/(10 [s])
superpotential layer(r) = normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)
superpotential slip(xi) = tresca(xi, bound = 3 [MPa])
state wear on ground with rate archard(layer.xi, u'.tau, coefficient = 1e-9 [1/Pa]) from wear = 0 [mm]
space V = vector P1 on slab, zero on left
find u in V for t in [0, 10] [s] by 4 steps from u = 0
such that for all v in V
    integral(slab, A : eps(u') : eps(v))
  + integral(slab, B : eps(u) : eps(v)) + integral(slab, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu) + slip^0(u'.tau; v.tau))
 >= integral(slab, dot([0, -78.5 [kN/m^3]], v)) + integral(roof, dot([0, -load*grow(t)], v))
report
  table tip = u.y at [20, 10] [mm], s = sigma.yy at [10, 5] [mm], p = layer.xi at [10 [mm], 0], R = reaction(left), N = norm(u)
expect tip = -1 [um] within 10 [mm]
"""

PLAIN = [("units mm, N, s\n", ""), ("70 [GPa] in", "70e3 in"), ("[10, 300] [GPa]", "[10e3, 300e3]"), ("2 [MPa]", "2"),
         ("20 [mm], 10 [mm]", "20, 10"), ("x > 5 [mm] and x < 15 [mm]", "x > 5 and x < 15"), ("5 [GPa*s], mu = 9 [GPa*s]", "5e3, mu = 9e3"),
         ("-0.25/(3 [s])*exp(-lag/(3 [s]))", "-0.25/3*exp(-lag/3)"), ("a/(10 [s])", "a/10"), ("100 [MPa/mm]", "100"),
         ("3 [MPa]", "3"), ("1e-9 [1/Pa]", "1e-3"), ("[0, 10] [s]", "[0, 10]"), ("-78.5 [kN/m^3]", "-78.5e-6"),
         ("[20, 10] [mm]", "[20, 10]"), ("[10, 5] [mm]", "[10, 5]"), ("[10 [mm], 0]", "[10, 0]"),
         ("wear = 0 [mm]", "wear = 0"), ("-1 [um] within 10 [mm]", "-1e-3 within 10")]

# (name, [(text of BASE, with units, in plain numbers)])
RIGHT = [
    ("the base itself", []),
    ("circles and the axis", [("rectangle(20 [mm], 10 [mm], cells = [2*n, n])", "rectangle(20 [mm], 10 [mm], cells = [2*n, n], axisymmetric = true)",
                               "rectangle(20, 10, cells = [2*n, n], axisymmetric = true)"),
                              ("part roof = slab.top", "part roof = slab.top\npart rim = point(slab, [20, 10] [mm])\npart pole = point(slab, [0, 10] [mm])",
                               "part roof = slab.top\npart rim = point(slab, [20, 10])\npart pole = point(slab, [0, 10])"),
                              ("integral(slab, dot([0, -78.5 [kN/m^3]], v))", "integral(rim, -0.2 [kN/m]*v.y) + integral(pole, -3 [N]*v.y)", "integral(rim, -0.2*v.y) + integral(pole, -3*v.y)")]),
    ("MPa for GPa", [("70 [GPa] in", "70000 [MPa] in", "70e3 in")]),
    ("Pa", [("70 [GPa] in", "70e9 [Pa] in", "70e3 in")]),
    ("N/mm^2", [("70 [GPa] in", "70e3 [N/mm^2] in", "70e3 in")]),
    ("kN/mm^2", [("70 [GPa] in", "70 [kN/mm^2] in", "70e3 in")]),
    ("J/cm^3", [("70 [GPa] in", "70e3 [J/cm^3] in", "70e3 in")]),
    ("kg/(m*s^2)", [("70 [GPa] in", "70e9 [kg/(m*s^2)] in", "70e3 in")]),
    ("kg*m^-1*s^-2", [("70 [GPa] in", "70e9 [kg*m^-1*s^-2] in", "70e3 in")]),
    ("bar", [("2 [MPa]", "20 [bar]", "2")]),
    ("tonnes", [("70 [GPa] in", "70e3 [t/(mm*s^2)] in", "70e3 in")]),
    ("a parenthesis with a unit", [("2 [MPa]", "(1 + 1) [MPa]", "2")]),
    ("a unit of a product", [("2 [MPa]", "2*1 [MPa]", "2")]),
    ("a negative one", [("2 [MPa]", "-(-2 [MPa])", "2")]),
    ("a power", [("2 [MPa]", "(2 [N])*(1 [mm])^-2", "2")]),
    ("a square root", [("2 [MPa]", "sqrt(4 [MPa^2])", "2")]),
    ("a fractional power", [("2 [MPa]", "(4 [MPa])^0.5*(1 [MPa])^(1/2)", "2")]),
    ("a fractional unit", [("2 [MPa]", "2 [MPa*m^(1/2)]/(1 [m^(1/2)])", "2")]),
    ("centimetres", [("20 [mm], 10 [mm]", "2 [cm], 1 [cm]", "20, 10")]),
    ("metres", [("20 [mm], 10 [mm]", "0.02 [m], 0.01 [m]", "20, 10")]),
    ("mixed", [("20 [mm], 10 [mm]", "2 [cm], 10 [mm]", "20, 10")]),
    ("hours", [("[0, 10] [s]", "[0, 0.5] [h]", "[0, 1800]")]),
    ("minutes", [("[0, 10] [s]", "[0, 1 [min]]", "[0, 60]")]),
    ("milliseconds", [("[0, 10] [s]", "[0, 500] [ms]", "[0, 0.5]")]),
    ("zero has every unit", [("-78.5 [kN/m^3]", "0", "0")]),
    ("zero with a unit", [("-78.5 [kN/m^3]", "0 [N/m^3]", "0")]),
    ("weight from density", [("-78.5 [kN/m^3]", "-8000 [kg/m^3]*9.81 [m/s^2]", "-8e-9*9810")]),
    ("an angle", [("2 [MPa]", "4 [MPa]*sin(30 [deg])", "4*sin(30*(pi/180))")]),
    ("radians", [("2 [MPa]", "4 [MPa]*sin(0.5 [rad])", "4*sin(0.5)")]),
    ("percent", [("nu = 0.3", "nu = 30 [percent]", "nu = 0.3")]),
    ("a ratio", [("nu = 0.3", "nu = 3 [mm]/(10 [mm])", "nu = 3/10")]),
    ("a converted ratio", [("nu = 0.3", "nu = 3 [mm]/(1 [cm])", "nu = 0.3")]),
    ("min and max", [("2 [MPa]", "max(min(2 [MPa], 1 [GPa]), 0)", "max(min(2, 1e3), 0)")]),
    ("abs and pos", [("2 [MPa]", "abs(-1 [MPa]) + pos(1 [MPa])", "abs(-1) + pos(1)")]),
    ("atan2", [("2 [MPa]", "2 [MPa]*atan2(1 [mm], 1 [m])", "2*atan2(1, 1000)")]),
    ("exp of a number", [("2 [MPa]", "2 [MPa]*exp(-1 [s]/(2 [s]))", "2*exp(-0.5)")]),
    ("cases", [("a/(10 [s])", "| a < 5 [s] -> a/(10 [s]) | otherwise -> 0.5", "| a < 5 -> a/10 | otherwise -> 0.5")]),
    ("not, or", [("x > 5 [mm] and x < 15 [mm]", "not (x < 5 [mm] or x > 15 [mm])", "not (x < 5 or x > 15)")]),
    ("lame's moduli", [("young = E, poisson = nu", "lambda = 40 [GPa], mu = 27 [GPa]", "lambda = 40e3, mu = 27e3")]),
    ("a library's tensor", [("isotropic(young = E, poisson = nu)", "young_poisson(E, nu)", "young_poisson(E, nu)")]),
    ("plane stress", [("isotropic(young = E, poisson = nu)", "plane_stress(E, nu)", "plane_stress(E, nu)")]),
    ("bulk and shear", [("isotropic(young = E, poisson = nu)", "bulk_shear(58 [GPa], 27 [GPa])", "bulk_shear(58e3, 27e3)")]),
    ("orthotropic", [("isotropic(young = E, poisson = nu)", "orthotropic(young = [70, 60, 50] [GPa], poisson = [0.3, 0.3, 0.3], shear = [20, 20, 20] [GPa])",
                      "orthotropic(young = [70e3, 60e3, 50e3], poisson = [0.3, 0.3, 0.3], shear = [20e3, 20e3, 20e3])")]),
    ("voigt", [("isotropic(young = E, poisson = nu)", "voigt([[90, 30, 0], [30, 90, 0], [0, 0, 30]] [GPa])",
                "voigt([[90e3, 30e3, 0], [30e3, 90e3, 0], [0, 0, 30e3]])")]),
    ("a standard linear solid", [("-0.25/(3 [s])*exp(-lag/(3 [s]))", "standard_linear_solid(lag, 0.25, 3 [s])", "standard_linear_solid(lag, 0.25, 3)")]),
    ("two elements", [("-0.25/(3 [s])*exp(-lag/(3 [s]))", "maxwell_chain_2(lag, 0.1, 1 [s], 0.2, 5 [s])", "maxwell_chain_2(lag, 0.1, 1, 0.2, 5)")]),
    ("a prony series", [("-0.25/(3 [s])*exp(-lag/(3 [s]))", "prony(weights = [-0.1, -0.02] [1/s], times = [1, 5] [s])", "prony(weights = [-0.1, -0.02], times = [1, 5])")]),
    ("a relaxation", [("-0.25/(3 [s])*exp(-lag/(3 [s]))", "prony_relaxation(weights = [0.1, 0.2], times = [1, 5] [s])", "prony_relaxation(weights = [0.1, 0.2], times = [1, 5])")]),
    ("a kernel of t and s", [("C(lag) = -0.25/(3 [s])*exp(-lag/(3 [s]))", "C(t, s) = -0.25/(3 [s])*exp(-(t - s)/(3 [s]))", "C(t, s) = -0.25/3*exp(-(t - s)/3)")]),
    ("a power of two", [("stiffness = 100 [MPa/mm], power = 1", "stiffness = 100 [MPa/mm^2], power = 2", "stiffness = 100, power = 2")]),
    ("a power of three halves", [("stiffness = 100 [MPa/mm], power = 1", "stiffness = 100 [MPa/mm^(3/2)], power = 1.5", "stiffness = 100, power = 1.5")]),
    ("a bound", [("normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "bounded_compliance(r, stiffness = 100 [MPa/mm], bound = 5 [MPa])",
                  "bounded_compliance(r, stiffness = 100, bound = 5)")]),
    ("unilateral contact", [("normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "unilateral(r, gap = 1 [um])", "unilateral(r, gap = 1e-3)")]),
    ("a winkler foundation", [("normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "winkler(r, stiffness = 0.1 [GPa/mm])", "winkler(r, stiffness = 100)")]),
    ("a law by its slope", [("= normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "with slope | r < 0 -> 0 | otherwise -> 100 [MPa/mm]*r",
                             "with slope | r < 0 -> 0 | otherwise -> 100*r")]),
    ("a law by its potential", [("= normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "= 50 [MPa/mm]*max(r, 0)^2", "= 50*max(r, 0)^2")]),
    ("a regularised friction", [("tresca(xi, bound = 3 [MPa])", "bounded_friction(xi, bound = 3 [MPa], range = 1 [mm/s])", "bounded_friction(xi, bound = 3, range = 1)")]),
    ("stribeck's friction", [("tresca(xi, bound = 3 [MPa])", "stribeck(xi, static = 3 [MPa], dry = 2 [MPa], range = 1 [um/s], wet = 1 [MPa*s/m])",
                              "stribeck(xi, static = 3, dry = 2, range = 1e-3, wet = 1e-3)")]),
    ("a ramp of the library", [("load*grow(t)", "load*ramp(t, 10 [s])", "load*ramp(t, 10)")]),
    ("a cycle", [("load*grow(t)", "load*cycle(t, 20 [s])", "load*cycle(t, 20)")]),
    ("a declared unit of u", [("find u in V", "find u [um] in V", "find u in V")]),
    ("an initial value", [("from u = 0\n", "from u = [0 [mm], 0]\n", "from u = [0, 0]\n")]),
    ("a bare zero in a range", [("[10, 300] [GPa]", "[0, 300 [GPa]]", "[0, 300e3]")]),
    ("every time", [("[0, 10] [s] by 4 steps", "[0, 10] [s] at [1, 2, 5, 10] [s]", "[0, 10] at [1, 2, 5, 10]")]),
    ("counts that are ratios", [("by 4 steps", "by 4 [s]/(1 [s]) steps", "by 4 steps"), ("cells = [2*n, n]", "[2*n, 2 [mm]/(1 [mm])]", "cells = [2*n, n]")]),
    ("kilonewtons and metres", [("units mm, N, s", "units mm, MPa, s", "")]),
]

# (name, text of BASE, what stands there instead, what is underlined, code)
WRONG = [
    ("a length and a time", "2 [MPa]", "2 [MPa] + 0*(3 [mm] + 4 [s])", "4 [s]", "E0331"),
    ("a difference", "2 [MPa]", "2 [MPa] - 1 [N]", "1 [N]", "E0331"),
    ("a bare number in a sum", "2 [MPa]", "2 [MPa] + 1", "1", "E0332"),
    ("a bare number before it", "2 [MPa]", "1 + 2 [MPa]", "2 [MPa]", "E0332"),
    ("an unknown unit", "2 [MPa]", "2 [Mpa]", "[Mpa]", "E0330"),
    ("another unknown unit", "2 [MPa]", "2 [newtons]", "[newtons]", "E0330"),
    ("a micro sign", "2 [MPa]", "2e12 [\u00b5Pa]", "\u00b5Pa", "E0330"),
    ("a prefix that a unit does not have", "2 [MPa]", "2 [MPa]*1 [kmin]/(1 [min])", "[kmin]", "E0330"),
    ("a percent sign", "2 [MPa]", "2 [MPa]*100 [%]", "%", "E0110"),
    ("a degree sign", "2 [MPa]", "2 [MPa]*sin(90 [\u00b0])", "\u00b0", "E0101"),
    ("a product without a sign", "2 [MPa]", "2 [MPa]*1 [Nm]/(1 [N*m])", "[Nm]", "E0330"),
    ("degrees Celsius", "2 [MPa]", "2 [MPa]*20 [degC]/(20 [K])", "[degC]", "E0330"),
    ("a power without a sign", "2 [MPa]", "2 [N/mm2]", "[N/mm2]", "E0330"),
    ("a number in a unit", "2 [MPa]", "2 [10*mm]", "[10*mm]", "E0330"),
    ("a blank as product", "2 [MPa]", "2 [N m]", "m", "E0230"),
    ("an empty unit", "2 [MPa]", "2 []", "]", "E0230"),
    ("a unit on a quantity", "2 [MPa]", "(2 [MPa]) [MPa]", "[MPa]", "E0331"),
    ("the range in another dimension", "in [10, 300] [GPa]", "in [1, 300e3] [mm]", "1", "E0331"),
    ("a value of another kind than its range", "70 [GPa] in", "70 [mm] in", "10", "E0331"),
    ("a bare value beside a range", "70 [GPa] in", "70 in", "10", "E0331"),
    ("a range of what is computed", "70 [GPa] in [10, 300] [GPa]", "2*35 [GPa] in [10, 300e3] [mm]", "10", "E0331"),
    ("a place of a mesh", "10 [mm], cells", "10 [mm], at = [1, 0] [s], cells", "1", "E0331"),
    ("an expectation's condition", "within 10 [mm]", "within 10 [mm] when load > 1", "1", "E0332"),
    ("the end of a line", "N = norm(u)", "N = norm(u)\n  line u from [0, 5] [mm] to [20, 5] by 3 points", "20", "E0332"),
    ("the beginning of a line", "N = norm(u)", "N = norm(u)\n  line u from [1, 5] [s] to [20, 5] [mm] by 3 points", "1", "E0331"),
    ("an initial rate", "integral(slab, A : eps(u') : eps(v))\n", "integral(slab, A : eps(u') : eps(v)) + integral(slab, 1 [g/cm^3]*dot(u'', v))\n", "", "E0331", ("from u = 0\n", "from u = 0, u' = [1 [mm], 0]\n", "1 [mm]")),
    ("a bare range", "in [10, 300] [GPa]", "in [10, 1e12]", "10", "E0332"),
    ("a bare mesh", "20 [mm], 10 [mm]", "20, 10 [mm]", "20", "E0332"),
    ("a mesh in seconds", "20 [mm], 10 [mm]", "20 [mm], 10 [s]", "10 [s]", "E0331"),
    ("a bare condition", "x > 5 [mm]", "x > 5", "5", "E0332"),
    ("a wrong condition", "x > 5 [mm]", "x > 5 [N]", "5 [N]", "E0331"),
    ("a modulus in mm", "5 [GPa*s], mu", "5 [mm], mu", "9 [GPa*s]", "E0331"),
    ("a poisson's ratio in Pa", "poisson = nu", "poisson = 0.3 [MPa]", "0.3 [MPa]", "E0331"),
    ("a bare modulus", "young = E, poisson = nu", "lambda = 40 [GPa], mu = 27e3", "27e3", "E0332"),
    ("an exponential of a time", "exp(-lag/(3 [s]))", "exp(-lag)", "-lag", "E0331"),
    ("an exponential of a bare quotient", "exp(-lag/(3 [s]))", "exp(-lag/3)", "-lag/3", "E0331"),
    ("a sine of a length", "2 [MPa]", "2 [MPa]*sin(3 [mm])", "3 [mm]", "E0331"),
    ("a logarithm", "2 [MPa]", "2 [MPa]*log(3 [s])", "3 [s]", "E0331"),
    ("an exponent with a unit", "2 [MPa]", "2 [MPa]*2^(1 [s])", "(1 [s])", "E0331"),
    ("min of two kinds", "2 [MPa]", "min(2 [MPa], 3 [mm])", "3 [mm]", "E0331"),
    ("max with a bare number", "2 [MPa]", "max(2 [MPa], 1)", "1", "E0332"),
    ("atan2 of two kinds", "2 [MPa]", "2 [MPa]*atan2(1 [mm], 1 [s])", "1 [s]", "E0331"),
    ("a list of two kinds", "[0, -78.5 [kN/m^3]]", "[1 [N], -78.5 [kN/m^3]]", "-78.5 [kN/m^3]", "E0331"),
    ("a traction as a load of volume", "-78.5 [kN/m^3]", "-78.5 [kN/m^2]", "dot([0, -78.5 [kN/m^2]], v)", "E0331"),
    ("a force as a load of volume", "-78.5 [kN/m^3]", "-78.5 [kN]", "dot([0, -78.5 [kN]], v)", "E0331"),
    ("a bare load", "-78.5 [kN/m^3]", "-78.5", "dot([0, -78.5], v)", "E0331"),
    ("a density as a load", "-78.5 [kN/m^3]", "-7850 [kg/m^3]", "dot([0, -7850 [kg/m^3]], v)", "E0331"),
    ("a load of volume on the boundary", "load = 2 [MPa]", "load = 2 [N/m^3]", "dot([0, -load*grow(t)], v)", "E0331"),
    ("a force on the boundary", "load = 2 [MPa]", "load = 2 [N]", "dot([0, -load*grow(t)], v)", "E0331"),
    ("a kernel without its time", "-0.25/(3 [s])*exp", "-0.25*exp", "history(C, eps(u)) : eps(v)", "E0331"),
    ("viscosity without its time", "lambda = 5 [GPa*s], mu = 9 [GPa*s]", "lambda = 5 [GPa], mu = 9 [GPa]", "A : eps(u') : eps(v)", "E0331"),
    ("a stiffness in Pa", "stiffness = 100 [MPa/mm]", "stiffness = 100 [MPa]", "slip^0", "E0331+"),
    ("a stiffness without a unit", "stiffness = 100 [MPa/mm]", "stiffness = 100", "slip^0", "E0331+"),
    ("a bound in mm", "bound = 3 [MPa]", "bound = 3 [mm]", "slip^0", "E0331"),
    ("a power with a unit", "power = 1", "power = 1 [mm]", "", "E0331"),
    ("a wrong gap", "normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "unilateral(r, gap = 1 [s])", "unilateral(r, gap = 1 [s])", "E0331"),
    ("a bare gap", "normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)", "unilateral(r, gap = 1)", "unilateral(r, gap = 1)", "E0332"),
    ("a bound against a stiffness", "normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)",
     "bounded_compliance(r, stiffness = 100 [MPa/mm], bound = 5 [mm])", "bounded_compliance(r, stiffness = 100 [MPa/mm], bound = 5 [mm])", "E0331"),
    ("a range of slip rates in mm", "tresca(xi, bound = 3 [MPa])", "bounded_friction(xi, bound = 3 [MPa], range = 1 [mm])",
     "bounded_friction(xi, bound = 3 [MPa], range = 1 [mm])", "E0331"),
    ("a bare time", "[0, 10] [s] by", "[0, 10] by", "10", "E0332"),
    ("a time in mm", "[0, 10] [s] by", "[0, 10] [mm] by", "0", "E0331"),
    ("a bare time of steps", "[0, 10] [s] by 4 steps", "[0, 10] [s] at [1, 2, 5, 10]", "1", "E0332"),
    ("an initial value in seconds", "from u = 0\n", "from u = [1 [s], 0]\n", "1 [s]", "E0331"),
    ("a bare initial value", "from u = 0\n", "from u = [1, 0]\n", "1", "E0332"),
    ("a bare point", "[20, 10] [mm]", "[20, 10]", "20", "E0332"),
    ("a point in seconds", "[20, 10] [mm]", "[20, 10] [s]", "20", "E0331"),
    ("a bare expectation", "-1 [um] within", "-1 within", "-1", "E0332"),
    ("an expectation in Pa", "-1 [um] within", "-1 [Pa] within", "-1 [Pa]", "E0331"),
    ("a bare tolerance", "within 10 [mm]", "within 10", "10", "E0332"),
    ("a tolerance in N", "within 10 [mm]", "within 10 [N]", "10 [N]", "E0331"),
    ("a relative tolerance with a unit", "within 10 [mm]", "within 10 [mm] relative", "10 [mm]", "E0331"),
    ("a column of two kinds", "tip = u.y at", "tip = u.y + sigma.yy at", "sigma.yy", "E0331"),
    ("a column and a number", "tip = u.y at", "tip = u.y + 1 at", "1", "E0332"),
    ("a fn called with two kinds", "load*grow(t)", "load*grow(x)", "dot([0, -load*grow(x)], v)", "E0331"),
    ("a library's ramp", "load*grow(t)", "load*ramp(t, 10 [mm])", "ramp(t, 10 [mm])", "E0332"),
    ("a bare ramp", "load*grow(t)", "load*ramp(t, 10)", "ramp(t, 10)", "E0332"),
    ("a case of another kind", "a/(10 [s])", "| a < 5 [s] -> a/(10 [s]) | otherwise -> 1 [s]", "1 [s]", "E0332"),
    ("a case's condition", "a/(10 [s])", "| a < 5 -> a/(10 [s]) | otherwise -> 1", "5", "E0332"),
    ("times of a series", "-0.25/(3 [s])*exp(-lag/(3 [s]))", "prony(weights = [-0.1] [1/s], times = [1] [mm])", "[1]", "E0331"),
    ("a wear in 1/N", "1e-9 [1/Pa]", "1e-9 [1/N]", "archard(layer.xi, u'.tau, coefficient = 1e-9 [1/N])", "E0331"),
    ("a system of dependent units", "units mm, N, s", "units mm, N, MPa", "MPa", "E0333"),
    ("a system of a number", "units mm, N, s", "units mm, N, rad", "rad", "E0333"),
    ("two systems", "units mm, N, s\n", "units mm, N, s\nunits SI\n", "units SI", "E0333"),
    ("two systems, the short one first", "units mm, N, s\n", "units SI\nunits mm, N, s\n", "units mm, N, s", "E0333"),
    ("a system with an unknown unit", "units mm, N, s", "units mm, Newton, s", "Newton", "E0330"),
    ("a number of steps", "by 4 steps", "by 4 [s] steps", "4 [s]", "E0331"),
    ("a number of steps by a parameter", "by 4 steps", "by load steps", "load", "E0331"),
    ("steps of a grading", "by 4 steps", "at graded(4 [s], 2)", "4 [s]", "E0331"),
    ("the power of a grading", "by 4 steps", "at graded(4, power = 2 [s])", "2 [s]", "E0331"),
    ("a tolerance of a step", "from u = 0\n", "from u = 0 using tolerance = 1e-10 [mm]\n", "1e-10 [mm]", "E0331"),
    ("a tolerance of a memory", "from u = 0\n", "from u = 0 using memory_tolerance = 1e-8 [1/s]\n", "1e-8 [1/s]", "E0331"),
    ("a wanted accuracy", "from u = 0\n", "from u = 0 using accuracy = 1 [um]\n", "1 [um]", "E0331"),
    ("threads", "from u = 0\n", "from u = 0 using threads = 1 [s]\n", "1 [s]", "E0331"),
    ("a number of cells", "cells = [2*n, n]", "cells = [2 [mm], n]", "2 [mm]", "E0331"),
    ("a number of cells of an adapted mesh", "cells = [2*n, n]", "cells = [2*n, n], adapted = 40 [mm]", "40 [mm]", "E0331"),
    ("the grading of a mesh", "cells = [2*n, n]", "cells = [2*n, n], grading = [1, 2 [mm]]", "2 [mm]", "E0331"),
    ("a radius", "rectangle(20 [mm], 10 [mm], cells = [2*n, n])", "disk(radius = 20 [s], size = 8 [mm])", "20 [s]", "E0331",
     None, ("slab.left", "slab.rim"), ("slab.bottom", "slab.rim"), ("slab.top", "slab.rim")),
    ("a bare size", "rectangle(20 [mm], 10 [mm], cells = [2*n, n])", "disk(radius = 20 [mm], size = 8)", "8", "E0332",
     None, ("slab.left", "slab.rim"), ("slab.bottom", "slab.rim"), ("slab.top", "slab.rim")),
    ("rows of a table", "N = norm(u)", "N = norm(u) every 2 [s] steps", "2 [s]", "E0331"),
    ("fields", "N = norm(u)", "N = norm(u)\n  fields u every 2 [s] steps", "2 [s]", "E0331"),
    ("points of a line", "N = norm(u)", "N = norm(u)\n  line u from [0, 5] [mm] to [20, 5] [mm] by 3 [mm] points", "3 [mm]", "E0331"),
    ("the time of a value", "N = norm(u)", "N = norm(u), half = u.y at [20, 10] [mm] at t = 5 [mm]", "5 [mm]", "E0331"),
    ("a bare time of a value", "N = norm(u)", "N = norm(u), half = u.y at [20, 10] [mm] at t = 5", "5", "E0332"),
    ("the factor of a deformed picture", "N = norm(u)", "N = norm(u)\n  picture u deformed = 2 [mm]", "2 [mm]", "E0331"),
    ("a bare rung", "within 10 [mm]\n", "within 10 [mm]\nstudy vary load in [1 [MPa], 2] against finest\n", "2", "E0332"),
    ("rungs of another kind", "within 10 [mm]\n", "within 10 [mm]\nstudy vary load in [1, 2] [mm] against finest\n", "1", "E0331"),
    ("a bare rung of the second parameter", "within 10 [mm]\n", "within 10 [mm]\nstudy vary n, load in [[2, 1 [MPa]], [4, 2]] against finest\n", "2", "E0332"),
    ("an exact solution", "within 10 [mm]\n", "within 10 [mm]\nstudy vary n in [2, 4] against exact [x/(1 [s]), 0] in V\n", "x/(1 [s])", "E0331"),
    ("a velocity for a displacement", "find u in V", "find u [mm/s] in V", "slip^0", "E0331+"),
]


# Two bodies with a pair of sides between them, two unknowns, a state.
SEVERAL = """units mm, N, s
import contact
mesh upper = rectangle(20 [mm], 10 [mm], cells = [4, 2])
mesh lower = rectangle(20 [mm], 10 [mm], cells = [3, 2], at = [0, -10] [mm])
mesh both = upper + lower
part base = lower.bottom
part top = upper.top
part seam = pair(lower.top, upper.bottom, reach = 1 [mm])
tensor B = isotropic(young = 70 [GPa], poisson = 0.3)
superpotential touch(r) = normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)
state slid on seam with rate norm(jump(u').tau) from slid = 0 [mm] in [0, 2] [mm]
space V = vector P1 on both, zero on base, zero.x on top
space W = scalar P1 on upper, zero on top
find u in V, theta [K] in W with theta = 300 [K] on top for t in [0, 1] [s] by 2 steps from u = 0, theta = 300 [K]
such that for all v in V, eta in W
    integral(both, B : eps(u) : eps(v)) + integral(seam, touch^0(jump(u).nu; jump(v).nu))
  + integral(upper, 1 [N/K^2]*dot(grad(theta), grad(eta)))
 >= 0
report
  table warm = theta at [10, 5] [mm], slid = slid at [20 [mm], 0]
"""

WRONG_OF_SEVERAL = [
    ("a reach in seconds", "reach = 1 [mm]", "reach = 1 [s]", "1 [s]", "E0331"),
    ("a bare reach", "reach = 1 [mm]", "reach = 1", "1", "E0332"),
    ("the range of a state", "in [0, 2] [mm]", "in [0, 2] [s]", "0", "E0331"),
    ("a bare range of a state", "in [0, 2] [mm]", "in [0, 2]", "2", "E0332"),
    ("an imposed value of the other unknown", "theta = 300 [K] on top", "theta = 300 [mm] on top", "300 [mm]", "E0331"),
    ("the exact solution of the other unknown", "slid at [20 [mm], 0]\n", "slid at [20 [mm], 0]\nparam N = 2\nstudy vary N in [2, 4] against exact [[x, y], x]\n", "x", "E0331"),
    ("a start of the other unknown", "u = 0, theta = 300 [K]", "u = 0, theta = 300 [mm]", "300 [mm]", "E0331"),
]


def run(text, *arguments):
    path = WORK / "script.hvi"
    path.write_text(text)
    return subprocess.run([PROGRAM, *arguments, str(path)], capture_output=True, text=True, timeout=60)


def result_of(text):
    done = run(text, "run", "--quiet", "-o", str(WORK / "out"), "--json", str(WORK / "out.json"))
    if done.returncode not in (0, 5):
        return done.stderr
    return json.loads((WORK / "out.json").read_text())


def right(name, changes):
    with_units, plain = BASE, BASE
    for old, new, number in changes:
        assert old in BASE, old
        with_units = with_units.replace(old, new)
    for old, new in PLAIN:
        plain = plain.replace(old, new) if not any(old in change[0] or change[0] in old for change in changes) else plain
    for old, _, number in changes:
        plain = plain.replace(old, number)
    for old, new in PLAIN:
        plain = plain.replace(old, new)
    a, b = result_of(with_units), result_of(plain)
    if isinstance(a, str) or isinstance(b, str):
        failures.append(f"right: {name}: {a if isinstance(a, str) else b}\n{with_units if isinstance(a, str) else plain}")
        return False
    worst = 0.0
    for column, values in b["table"].items():
        size = max((abs(v) for v in values if v is not None), default=0.0) or 1.0
        worst = max([worst] + [abs(v - w) / size for v, w in zip(values, a["table"][column]) if v is not None])
    if worst > 1e-11:
        failures.append(f"right: {name}: differs by {worst:.2e}")
    if "units" in b or a["units"].get("tip") != "mm":
        failures.append(f"right: {name}: units {a.get('units')}, without {b.get('units')}")
    return worst == 0.0


def told(text):
    done = run(text, "check", "--diagnostics", "json")
    rows = [json.loads(line) for line in done.stderr.splitlines()]
    return [r for r in rows if r["code"].startswith("E")]


def wrong(name, old, new, bad, code, more=None, *other, base=BASE):
    """`more`: another change, with what is underlined then. `other`: changes that make it a script but for the mistake."""
    assert base.count(old) == 1, (name, old)
    text = base.replace(old, new)
    for change in other:
        text = text.replace(*change)
    if more:
        assert not told(text), (name, told(text))
        text, bad = text.replace(*more[:2]), more[2]
    rows = told(text)
    lines = text.split("\n")
    good, several = False, code.endswith("+")
    code = code.rstrip("+")
    for row in rows:
        line = lines[row["line"] - 1]
        under = line[row["column"] - 1:row["end_column"] - 1]
        good = good or (row["code"] == code and (under == bad or not bad or under.startswith(bad)))
    if not good or len(rows) != 1 and not several:
        shown = [(r["code"], lines[r["line"] - 1][r["column"] - 1:r["end_column"] - 1], r["message"]) for r in rows]
        failures.append(f"wrong: {name}: expected {code} at {bad!r}, told {shown}")
    elif code in ("E0331", "E0332") and "[" not in rows[0]["message"]:
        failures.append(f"wrong: {name}: no unit in {rows[0]['message']!r}")


# --- random expressions, with a calculator of dimensions of its own

F = fractions.Fraction
#              m  kg  s   K, and the value in the SI
UNITS = {"m": ((1, 0, 0, 0), 1.0), "mm": ((1, 0, 0, 0), 1e-3), "km": ((1, 0, 0, 0), 1e3), "kg": ((0, 1, 0, 0), 1.0), "g": ((0, 1, 0, 0), 1e-3),
         "t": ((0, 1, 0, 0), 1e3), "s": ((0, 0, 1, 0), 1.0), "ms": ((0, 0, 1, 0), 1e-3), "h": ((0, 0, 1, 0), 3600.0), "K": ((0, 0, 0, 1), 1.0),
         "N": ((1, 1, -2, 0), 1.0), "kN": ((1, 1, -2, 0), 1e3), "Pa": ((-1, 1, -2, 0), 1.0), "MPa": ((-1, 1, -2, 0), 1e6),
         "GPa": ((-1, 1, -2, 0), 1e9), "J": ((2, 1, -2, 0), 1.0), "kJ": ((2, 1, -2, 0), 1e3), "W": ((2, 1, -3, 0), 1.0), "rad": ((0, 0, 0, 0), 1.0)}


class Mismatch(Exception):
    pass


def scale(unit):
    return tuple(F(p) for p in UNITS[unit][0]), UNITS[unit][1]


def random_unit(rng):
    """Its text, dimension and value."""
    text, dims, size = rng.choice(list(UNITS)), None, None
    dims, size = scale(text)
    for _ in range(rng.choice([0, 0, 1, 2])):
        other, power, op = rng.choice(list(UNITS)), rng.choice([1, 1, 2, 3]), rng.choice("*/")
        d, v = scale(other)
        sign = power if op == "*" else -power
        text += op + other + (f"^{power}" if power > 1 else "")
        dims, size = tuple(a + sign * b for a, b in zip(dims, d)), size * v ** sign
    return text, dims, size


def tree(rng, depth):
    """(text, dimension, value); a sum of two dimensions raises Mismatch only when asked for with `evil`."""
    if depth == 0 or rng.random() < 0.2:
        number = round(rng.uniform(0.5, 9), 2)
        if rng.random() < 0.15:
            return f"{number}", (F(0),) * 4, number
        unit, dims, size = random_unit(rng)
        return f"{number} [{unit}]", dims, number * size
    kind = rng.choice(["*", "/", "^", "sqrt", "+", "-", "max", "abs", "ratio"])
    a = tree(rng, depth - 1)
    if kind == "sqrt":
        return f"sqrt(abs({a[0]}))", tuple(p / 2 for p in a[1]), math.sqrt(abs(a[2]))
    if kind == "abs":
        return f"abs({a[0]})", a[1], abs(a[2])
    if kind == "^":
        power = rng.choice([2, -1, F(1, 2)])
        return f"(abs({a[0]}))^({power})", tuple(p * power for p in a[1]), abs(a[2]) ** float(power)
    if kind in "*/":
        b = tree(rng, depth - 1)
        sign = 1 if kind == "*" else -1
        return f"({a[0]}){kind}({b[0]})", tuple(p + sign * q for p, q in zip(a[1], b[1])), a[2] * b[2] if sign > 0 else a[2] / b[2]
    if kind == "ratio":
        b = same_dimension(rng, a[1])
        return f"exp(-({b[0]})/({b[0]}))*({a[0]})", a[1], math.exp(-1) * a[2]
    b = same_dimension(rng, a[1])
    if kind == "max":
        return f"max({a[0]}, {b[0]})", a[1], max(a[2], b[2])
    return f"({a[0]} {kind} ({b[0]}))", a[1], a[2] + b[2] if kind == "+" else a[2] - b[2]


def power_text(name, power):
    return name if power == 1 else f"{name}^({power})" if power.denominator > 1 else f"{name}^{power}"


def same_dimension(rng, dims):
    """Another quantity of it, by base units."""
    number, size = round(rng.uniform(0.5, 9), 2), 1.0
    names = [rng.choice(["m", "mm", "km"]), rng.choice(["kg", "g", "t"]), rng.choice(["s", "ms", "h"]), "K"]
    text = "1"
    for name, power in zip(names, dims):
        if power:
            text += f"*{power_text(name, power)}" if power.denominator == 1 or True else ""
            size *= UNITS[name][1] ** float(power)
    if not any(dims):
        return f"{number}", dims, number
    if any(abs(p.numerator) > 12 or p.denominator > 12 for p in dims):
        return f"{number}*{product_of_powers(names, dims)}", dims, number * size
    return f"{number} [{text}]", dims, number * size


def product_of_powers(names, dims):
    return "*".join(f"(1 [{n}])^({p})" for n, p in zip(names, dims) if p)


def unit_value(text):
    """Dimension and value of a unit as the program names it: its own little reader."""
    dims, size = (F(0),) * 4, 1.0
    below = False
    for op, name, power in re.findall(r"([/*]?)\(?([A-Za-z]+|1)(?:\^(\(-?\d+/\d+\)|-?\d+))?\)?", text):
        below = op == "/" or (below and "(" in text and op == "*" and "/(" in text)
        if name == "1":
            continue
        exponent = F(power.strip("()")) if power else F(1)
        sign = -exponent if below else exponent
        d, v = known_unit(name)
        dims, size = tuple(a + sign * b for a, b in zip(dims, d)), size * v ** float(sign)
    return dims, size


def known_unit(name):
    if name in UNITS:
        return scale(name)
    prefixes = {"u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9, "n": 1e-9, "p": 1e-12, "T": 1e12}
    d, v = scale(name[1:])
    return d, v * prefixes[name[0]]


REST = """
param cells = 1
mesh body = rectangle(1 [m], 1 [m], cells = [cells, cells])
part left = body.left
space V = scalar P1 on body, zero on left
find u in V such that for all v in V integral(body, dot(grad(u), grad(v))) = integral(body, 1 [1/m^2]*v)
"""


def random_family(seed, scripts, each):
    rng = random.Random(seed)
    n_right = n_wrong = 0
    for index in range(scripts):
        system = rng.choice(["units SI\n", "units mm, N, s\n", "units kN, m, h\n", ""])
        lines, expected = [], []
        while len(lines) < each:
            text, dims, value = tree(rng, rng.choice([1, 2, 3, 4]))
            if not (1e-200 < abs(value) < 1e200) or any(abs(p) > 30 or p.denominator > 16 for p in dims):
                continue
            lines.append(f"param a{len(lines)} = 1*{text}")
            expected.append((dims, value))
        done = run(system + "\n".join(lines) + REST, "params")
        if done.returncode != 0:
            failures.append(f"random {index}: {done.stderr}")
            continue
        shown = dict(re.findall(r"^(a\d+) = (\S+(?: \[.*?\])?) \(number\)", done.stdout, re.M))
        for i, (dims, value) in enumerate(expected):
            number, _, unit = shown[f"a{i}"].partition(" ")
            got_dims, size = unit_value(unit.strip("[]") or "1")
            n_right += 1
            if got_dims != dims or abs(float(number) * size / value - 1) > 1e-9:
                failures.append(f"random {index}: {lines[i]}: {shown[f'a{i}']}, not {value} of {list(map(str, dims))}")
        # One sum of it with something of another dimension, which the calculator knows.
        which = rng.randrange(each)
        other = random_unit(rng)
        fits = other[1] == expected[which][0]
        lines[which] += f" + 3 [{other[0]}]"
        rows = told(system + "\n".join(lines) + REST)
        line = which + (2 if system else 1)
        n_wrong += not fits
        if bool(rows) == fits or any(r["code"] not in ("E0331", "E0332") or r["line"] != line for r in rows):
            failures.append(f"random {index}: {lines[which]}: fits {fits}, told {[(r['code'], r['line'], r['message']) for r in rows]}")
    return n_right, n_wrong


def declared_outside():
    """-D with a unit, without one in the declared unit, and in a script without units."""
    base = result_of(BASE)["table"]["tip"]
    changed = result_of(BASE.replace("E = 70 [GPa]", "E = 210 [GPa]"))["table"]["tip"]
    for define in ("E=210[GPa]", "E=210", "E=210000 [MPa]", "E=2.1e11[Pa]"):
        (WORK / "script.hvi").write_text(BASE)
        subprocess.run([PROGRAM, "run", "--quiet", "-D", define, "-o", str(WORK / "out"), "--json", str(WORK / "out.json"), str(WORK / "script.hvi")],
                       capture_output=True, text=True)
        got = json.loads((WORK / "out.json").read_text())
        if got["table"]["tip"] != changed or got["params"]["E"] != 210 and define != "E=2.1e11[Pa]" or got["table"]["tip"] == base:
            failures.append(f"-D {define}: {got['params']}, {got['table']['tip'][-1]} against {changed[-1]}")
    computed = BASE.replace("2 [MPa]", "2*1 [MPa]")
    for text, define, code in ((BASE, "E=210[mm]", "E0331"), (BASE, "E=210[Gpa]", "E0330"), (computed, "load=3[mm]", "E0331")):
        (WORK / "script.hvi").write_text(text)
        done = subprocess.run([PROGRAM, "check", "--diagnostics", "json", "-D", define, str(WORK / "script.hvi")], capture_output=True, text=True)
        if code not in done.stderr:
            failures.append(f"-D {define}: no {code} in {done.stderr}")
    (WORK / "script.hvi").write_text(BASE)
    done = subprocess.run([PROGRAM, "check", "-D", "E=7", str(WORK / "script.hvi")], capture_output=True, text=True)
    for words in ("`E` = 7 is outside its range [10, 300] [GPa]", "set by -D E=7\n"):
        if words not in done.stderr:
            failures.append(f"-D E=7: no {words!r} in {done.stderr}")
    (WORK / "script.hvi").write_text("param E = 70\n" + REST.replace("[m]", "").replace(" [1/m^2]", ""))
    done = subprocess.run([PROGRAM, "check", "--diagnostics", "json", "-D", "E=210[GPa]", str(WORK / "script.hvi")], capture_output=True, text=True)
    if "E0334" not in done.stderr:
        failures.append(f"a unit for a script without: {done.stderr}")


def reported():
    """The report shows parameters as the script declares them, not in the units of the computation."""
    (WORK / "script.hvi").write_text(BASE)
    done = subprocess.run([PROGRAM, "run", "--quiet", "--report", "-o", str(WORK / "page"), str(WORK / "script.hvi")], capture_output=True, text=True)
    pages = [page.read_text() for page in (WORK / "page").glob("*.html")]
    if len(pages) != 1 or '"70 [GPa]"' not in pages[0]:
        failures.append(f"report: {len(pages)} pages, without 70 [GPa]: {done.stderr}")


def formatted():
    """The formatter keeps units and sets them apart by one blank."""
    messy = "units mm,N , s\nparam  E=70[GPa]in[10,300][ GPa ]\nparam k = 3   [N*m^-2 * s^(-1/2)]\nparam m = (1+2)[kg / m^3]\n"
    tidy = "units mm, N, s\nparam E = 70 [GPa] in [10, 300] [GPa]\nparam k = 3 [N*m^-2 * s^(-1/2)]\nparam m = (1 + 2) [kg / m^3]\n"
    for text in (messy, tidy):
        (WORK / "script.hvi").write_text(text)
        subprocess.run([PROGRAM, "fmt", str(WORK / "script.hvi")], capture_output=True, text=True)
        if (WORK / "script.hvi").read_text() != tidy:
            failures.append(f"fmt: {(WORK / 'script.hvi').read_text()}")


def named():
    """Units as people write them, and what a function may be called with, whatever another one asks of the same name."""
    for force, length in (("kN", "cm"), ("N", "dm")):  # no hbar, no mbar
        (WORK / "script.hvi").write_text(f"units {length}, {force}, s\nparam p = 1*2 [{force}/{length}^2]\n" + REST)
        done = subprocess.run([PROGRAM, "params", str(WORK / "script.hvi")], capture_output=True, text=True)
        if f"p = 2 [{force}/{length}^2]" not in done.stdout:
            failures.append(f"params: {done.stdout}{done.stderr}")
    (WORK / "script.hvi").write_text("units mm, N, s\nfn bed(r) = 5 [N/mm^3]*r\nfn rate(time) = 1 [mm]/time^2\n" + REST)
    done = subprocess.run([PROGRAM, "dump", "--units", str(WORK / "script.hvi")], capture_output=True, text=True)
    if done.stdout != "bed(r [r]) [r*N/mm^3]\nrate(time [time]) [mm/time^2]\n":
        failures.append(f"dump --units: {done.stdout}{done.stderr}")
    free = REST.replace("1 [1/m^2]*v", "0*v").replace("\nspace", "\nfn first() = exp(u)\nfn second() = u + 1 [km]\nspace")
    (WORK / "script.hvi").write_text("units SI\n" + free)
    done = subprocess.run([PROGRAM, "dump", "--units", str(WORK / "script.hvi")], capture_output=True, text=True)
    if done.stdout != "first() [1]\nsecond() [m]\n":
        failures.append(f"dump --units: {done.stdout}{done.stderr}")


formatted()
named()
reported()
exact = sum(right(*case) for case in RIGHT)
for case in WRONG:
    wrong(*case)
if told(SEVERAL):
    failures.append(f"right: several unknowns: {told(SEVERAL)}")
for case in WRONG_OF_SEVERAL:
    wrong(*case, base=SEVERAL)
random_right, random_wrong = random_family(24, 12, 25)
declared_outside()
assert len(RIGHT) + len(WRONG) > 120 and random_wrong > 6
print(f"{len(RIGHT)} right scripts, {exact} of them to the last bit; {len(WRONG) + len(WRONG_OF_SEVERAL)} wrong ones; {random_right} random expressions and {random_wrong} wrong sums")
for failure in failures:
    print(failure)
sys.exit(bool(failures))
