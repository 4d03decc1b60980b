// Files of a run as independent readers see them: python3-meshio for VTU, jsonschema for JSON.
#include "solver/fem/geometry.hpp"
#include "solver/output/file.hpp"
#include "solver/results/result_json.hpp"
#include "solver/results/shown.hpp"
#include "solver/results/trust.hpp"
#include "tests/solver/time/plans.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

namespace hvi::solver {
namespace {

using namespace testing_plans;
namespace fs = std::filesystem;

fs::path fresh_folder(const std::string& name) {
  auto folder = fs::path(testing::TempDir()) / ("hvi_" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

/// Runs a Python program inside a folder; its exit code.
int python(const fs::path& folder, const std::string& program) {
  std::ofstream(folder / "check.py") << program;
  return std::system(("cd '" + folder.string() + "' && /usr/bin/python3 check.py").c_str());
}

Expr d(int i, int j) { return var(slot::field(field_of_u(0), slot::gradient(i, j))); }

/// The slab with u, a stress, the multiplier and a scalar of x among its fields.
Plan slab_with_fields(int order) {
  auto plan = slab(4, 8, 2, true);
  plan.problem.space.order = order;
  const Expr shear = 0.5 * (d(0, 1) + d(1, 0));
  FieldsSpec fields;
  fields.every = 3;
  fields.fields = {{"u", {}, {u_value(0), u_value(1)}},
                   {"eps", {}, {d(0, 0), shear, shear, d(1, 1)}},
                   {"layer.xi", {}, {var(slot::multiplier(0, 0))}},
                   {"slip.xi", {}, {var(slot::multiplier(1, 0)), var(slot::multiplier(1, 1))}},
                   {"height", {}, {var(slot::x(1)) * var(slot::t)}}};
  plan.report.fields = {fields};
  return plan;
}

TEST(Files, ATableEveryFewStepsEndsWithTheLastRow) {
  for (const int steps : {6, 7, 8}) {
    const auto folder = fresh_folder("every" + std::to_string(steps));
    RunSettings settings;
    settings.output_folder = folder.string();
    settings.name = "slab";
    auto plan = slab(2, steps);
    plan.report.tables = {{{}, {0}, 1, false, ""}, {{}, {0}, 3, false, "some.csv"}};
    solve(plan, settings);
    std::ifstream in(folder / "some.csv");
    std::vector<double> times;
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) times.push_back(std::stod(line) * steps);
    std::vector<double> expected = {3, 6};
    if (steps > 6) expected.push_back(steps);
    ASSERT_EQ(times.size(), expected.size());
    for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1e-12);
  }
}

TEST(Files, AMultiplierOfAPointIsAVertex) {
  const auto folder = fresh_folder("vertex");
  RunSettings settings;
  settings.output_folder = folder.string();
  settings.name = "slab";
  auto plan = slab(2, 4);
  PartSpec corner{"corner", {}, {}};
  corner.region.kind = RegionSpec::Kind::point;
  corner.region.point = {1, 0, 0};
  plan.problem.parts.push_back(corner);
  LawTerm support;
  support.origin = {200};
  support.name = "support";
  support.law = 0;
  support.part = static_cast<int>(plan.problem.parts.size()) - 1;
  LawTerm::Row row;
  row.u[1] = Expr(-1.0);
  support.rows = {row};
  plan.problem.law_terms.push_back(support);
  FieldsSpec fields;
  fields.every = 4;
  fields.fields = {{"xi", {}, {var(slot::multiplier(1, 0))}}};
  plan.report.fields = {fields};
  solve(plan, settings);
  EXPECT_EQ(0, python(folder, R"(
import glob, meshio
found = [meshio.read(name) for name in glob.glob("*.vtu")]
vertices = [m for m in found if [block.type for block in m.cells] == ["vertex"]]
assert found and len(vertices) == len(found), found
assert all(m.points.tolist() == [[1, 0, 0]] and len(m.cells[0].data) == 1 for m in vertices), vertices
)"));
}

TEST(Files, MeshioReadsTheFieldsOfARun) {
  for (const int order : {1, 2}) {
    const auto folder = fresh_folder("fields" + std::to_string(order));
    RunSettings settings;
    settings.output_folder = folder.string();
    settings.name = "slab";
    const auto result = solve(slab_with_fields(order), settings);
    // Steps 3, 6 and the last: body, two multipliers; the collection of them; and the table.
    EXPECT_EQ(result.files.size(), 3u * 3u + 1u + 1u);
    for (const std::string& file : result.files) EXPECT_TRUE(fs::exists(folder / file)) << file;
    std::ofstream(folder / "expected.py")
        << "u_y = " << std::hexfloat << '"' << result.final.at("u_y") << '"' << "\nreaction = \""
        << result.final.at("reaction") << "\"\norder = " << order;
    EXPECT_EQ(0, python(folder, R"(
import meshio, numpy as np, csv, xml.etree.ElementTree as E
import expected
m = meshio.read("slab_00008.vtu")
assert m.cells[0].type == ("triangle" if expected.order == 1 else "triangle6")
assert len(m.cells[0].data) == 64
u, eps = m.point_data["u"], m.cell_data["eps"][0]
assert u.shape == (len(m.points), 3) and eps.shape == (64, 9)
at = np.argmin(np.abs(m.points - [1, 0, 0]).sum(axis=1))
assert u[at, 1] == float.fromhex(expected.u_y), (u[at, 1], expected.u_y)
assert np.allclose(m.point_data["height"], m.points[:, 1], atol=1e-15)
# eps is the cell mean of the gradient: by Gauss, from the values on the edges
for c, nodes in enumerate(m.cells[0].data):
    p, v = m.points[nodes], u[nodes]
    area = 0.5 * ((p[1,0]-p[0,0])*(p[2,1]-p[0,1]) - (p[2,0]-p[0,0])*(p[1,1]-p[0,1]))
    assert area > 0
    grad = np.zeros((2, 2))
    for e, (a, b) in enumerate([(0, 1), (1, 2), (2, 0)]):
        normal = np.array([p[b,1]-p[a,1], p[a,0]-p[b,0]])
        mean = (v[a]+v[b])/2 if expected.order == 1 else (v[a]+v[b]+4*v[3+e])/6
        if expected.order == 2:  # VTK puts node 3 + e on edge e
            assert np.allclose(p[3+e], (p[a]+p[b])/2)
        grad += np.outer(mean[:2], normal) / area
    sym = (grad + grad.T) / 2
    assert np.allclose(eps[c].reshape(3, 3)[:2, :2], sym, atol=1e-13)
xi = meshio.read("slab_layer_xi_00008.vtu")
assert xi.cells[0].type == ("line" if expected.order == 1 else "line3")
x, value = xi.points[:, 0], xi.point_data["layer.xi"]
s = meshio.read("slab_slip_xi_00008.vtu").point_data["slip.xi"]
assert s.shape == (len(x), 3) and (s[:, 1] == 0).all() and np.abs(s[:, 0]).max() > 0
# the reaction once more: the nodal rule is the trapezoidal (P2: Simpson's) rule on the facets
total = 0
for nodes in xi.cells[0].data:
    h = abs(x[nodes[1]] - x[nodes[0]])
    total += h * (value[nodes].mean() if expected.order == 1 else value[nodes] @ [1, 1, 4] / 6)
assert abs(total / float.fromhex(expected.reaction) - 1) < 1e-13
rows = list(csv.DictReader(open("slab.csv")))
assert len(rows) == 8 and float(rows[-1]["u_y"]) == float.fromhex(expected.u_y)
times = [float(s.get("timestep")) for s in E.parse("slab.pvd").getroot().iter("DataSet")]
assert times == [0.375]*3 + [0.75]*3 + [1.0]*3
)")) << "order "
     << order;
  }
}

TEST(Files, ResultJsonFollowsItsSchema) {
  const auto folder = fresh_folder("json");
  auto plan = slab(4, 6);
  plan.problem.effects = {
      {"viscosity", EffectNote::State::on, {5}, ""},
      {"normal law `layer`", EffectNote::State::on, plan.problem.law_terms[0].origin, ""},
      {"first", EffectNote::State::on, {0}, ""},
      {"nowhere", EffectNote::State::on, {}, ""}};
  auto timed = plan.report.probes[0];
  timed.name = "half";
  timed.time = 0.5;
  plan.report.probes.push_back(timed);
  plan.report.tables[0].probes.push_back(4); // not known before t = .5: null in the table
  auto result = solve(plan);
  result.script = "slab.hvi";
  ResultContext context;
  context.params = {{"n", 4.0}};
  context.line_of = [](Origin origin) { return origin.id + 1; };
  context.bandwidth = 2e10;
  write_atomically(folder / "result.json", json_text(result_json(result, plan.problem, context)));
  EXPECT_EQ(0, python(folder, std::string(R"(
import json, jsonschema
result = json.load(open("result.json"))
schema = json.load(open(")") + HVI_SOURCE_DIR +
                                  R"(/docs/schema/hvi-result-1.schema.json"))
jsonschema.Draft202012Validator.check_schema(schema)
jsonschema.validate(result, schema, cls=jsonschema.Draft202012Validator)
assert result["table"]["t"] == [i / 6 for i in range(1, 7)]
assert result["table"]["u_y"][-1] == result["final"]["u_y"]
assert result["table"]["half"][:2] == [None, None] and result["table"]["half"][5] == result["final"]["half"]
assert result["plan"]["effects"][1]["line"] == 101 and result["plan"]["effects"][0]["state"] == "on"
assert result["certificate"]["certified"] is True
assert [e["line"] for e in result["plan"]["effects"][2:4]] == [1, 0]
limit, steps = result["timing"]["limit"], 6
assert limit["bandwidth"] > 0 and limit["swept_bytes"] > 0
assert abs(limit["sweeps"] * limit["bandwidth"] / limit["swept_bytes"] - 1) < 1e-12
assert abs(limit["sweeps_per_step"] * steps / limit["sweeps"] - 1) < 1e-12
)"));
}

/// Values, strains and multipliers together, at the points of the law: with midpoints each lies in
/// one facet of one cell, whose gradient is constant. In space on a side whose normal is along z.
TEST(Probes, MultipliersTimesFields) {
  for (const int dim : {2, 3}) {
    auto plan = slab(3, 3, dim);
    const int axis = dim - 1;
    if (dim == 3) {
      plan.problem.parts[ground] = group("ground", "back");
      plan.problem.loads[0] = force(body, {0.0, 0.0, -10.0 * var(slot::t)});
    }
    plan.problem.law_terms[0].rule = Rule::midpoint;
    const std::vector<int> fields = {slot::value(0),       slot::value(1),
                                     slot::gradient(0, 0), slot::gradient(1, 0),
                                     slot::gradient(1, 1), slot::gradient(0, axis)};
    plan.report.probes.clear(), plan.report.tables.clear();
    for (const int field : fields) {
      const Expr e = var(slot::multiplier(0, 0)) * var(slot::field(field_of_u(0), field));
      plan.report.probes.push_back(integral(std::to_string(field), e, ground));
      plan.report.probes.back().rule = Rule::midpoint;
    }
    Discretisation d;
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    const auto result = run(plan, d, {});
    std::map<std::string, double> expected;
    for (const auto f : d.parts[ground].entities) {
      const auto& facet = d.mesh.facets[f];
      const auto u = [&](int node, int i) { return result.u[d.space.dof(node, i)]; };
      const auto mean = [&](int i) {
        double sum = 0;
        for (int k = 0; k < dim; ++k) sum += u(facet.nodes[k], i) / dim;
        return sum;
      };
      const double r = -mean(axis);
      const double xi = r < 0 ? 0 : r < 0.02 ? 100 * r : r < 0.08 ? 2 - 15 * (r - 0.02) : 1.1;
      const auto geometry = cell_geometry(d.mesh, facet.cell);
      const auto gradient = [&](int i, int j) {
        double sum = 0;
        for (int k = 0; k <= dim; ++k)
          sum += geometry.gradient[k][j] * u(d.mesh.cells[facet.cell][k], i);
        return sum;
      };
      const double values[] = {mean(0),        mean(1),        gradient(0, 0),
                               gradient(1, 0), gradient(1, 1), gradient(0, axis)};
      for (std::size_t k = 0; k < fields.size(); ++k)
        expected[std::to_string(fields[k])] += facet_measure(d.mesh, f) * xi * values[k];
    }
    for (const auto& [name, value] : expected) {
      EXPECT_NEAR(result.final.at(name), value, 1e-9 * std::abs(value)) << dim << " " << name;
      EXPECT_GT(std::abs(value), 1e-7) << dim << " " << name;
    }
  }
}

// Analytic: with u affine between grid times, a probe in the middle is the mean of its neighbours.
TEST(Probes, BetweenGridTimesTheInterpolantIsAffine) {
  auto plan = slab(4, 8);
  auto timed = plan.report.probes[0];
  timed.name = "between";
  timed.time = (3 + 0.25) / 8;
  plan.report.probes.push_back(timed);
  const auto result = solve(plan);
  const auto& u = result.columns.at("u_y");
  EXPECT_NEAR(result.final.at("between"), 0.75 * u[2] + 0.25 * u[3], 1e-16);
}

// The states of all steps, by the callback, and the interpolant of the plan between them.
TEST(Pictures, AtATimeShowTheStateThen) {
  for (const bool constant : {false, true}) {
    auto plan = slab(4, 8, 2, true);
    plan.problem.time.interpolant = constant ? Interpolant::constant : Interpolant::affine;
    for (const double time : {0.0, (3 + 0.25) / 8, 0.5, 1.0})
      plan.report.pictures.push_back({{}, {"u", {}, {u_value(0), u_value(1)}}, time, ""});
    plan.report.pictures.push_back({{}, {"u", {}, {u_value(0)}}, {}, ""});
    std::vector<Vector> states;
    RunSettings settings;
    settings.on_step = [&](int, double, const Vector& u, const Vector&) { states.push_back(u); };
    const auto result = solve(plan, settings);
    ASSERT_EQ(states.size(), 8u);
    ASSERT_EQ(result.pictures.size(), 5u);
    EXPECT_EQ(result.pictures[0].u, Vector::Zero(states[0].size()).eval());
    const Vector between = constant ? states[3] : Vector(0.75 * states[2] + 0.25 * states[3]);
    const double size = between.lpNorm<Eigen::Infinity>();
    EXPECT_LE((result.pictures[1].u - between).lpNorm<Eigen::Infinity>(), 1e-14 * size);
    EXPECT_EQ(result.pictures[2].u, states[3]);
    EXPECT_EQ(result.pictures[3].u, states[7]);
    EXPECT_EQ(result.pictures[4].u, result.u);
  }
}

/// u at a place of the lower side of the first piece, which is affine between nodes.
double on_first_side(const Discretisation& d, const Vector& u, double x, int component) {
  std::map<double, double> values; // by x
  for (int cell = 0; cell < d.mesh.pieces[1]; ++cell)
    for (const auto node : d.space.nodes_of_cell(cell))
      if (const Point& p = d.space.nodes[static_cast<std::size_t>(node)]; p[1] == 0.0)
        values[p[0]] = u[d.space.dof(node, component)];
  auto after = values.lower_bound(x);
  if (after == values.begin()) ++after;
  const auto before = std::prev(after);
  const double part = (x - before->first) / (after->first - before->first);
  return (1.0 - part) * before->second + part * after->second;
}

/// The points of a law on a pair go with its first side, on which the forces act.
TEST(Pictures, ForcesOnAPairMoveWithTheBody) {
  Plan plan = two_blocks(4, 2, 2);
  plan.report.pictures = {{{}, {"xi", {}, {var(slot::multiplier(0, 0))}}, {}, ""}};
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  Shown shown;
  const RunResult result = run_shown(plan, d, {}, shown);
  const VtuGrid& law = shown.pictures.at(0).at(0).grids.back().grid;
  const auto moved = std::ranges::find(law.point_data, displacement_array, &VtuArray::name);
  ASSERT_NE(moved, law.point_data.end());
  ASSERT_FALSE(law.points.empty());
  double largest = 0.0;
  for (std::size_t p = 0; p < law.points.size(); ++p)
    for (int i = 0; i < 2; ++i) {
      const double here = moved->values[3 * p + static_cast<std::size_t>(i)];
      EXPECT_NEAR(here, on_first_side(d, result.u, law.points[p][0], i), 1e-12);
      largest = std::max(largest, std::abs(here));
    }
  EXPECT_GT(largest, 1e-3);
}

TEST(Pictures, OutsideTheTimeIntervalAreRefused) {
  for (const double time : {-0.1, 1.5}) {
    auto plan = slab(2, 2);
    plan.report.pictures.push_back({{}, {"u", {}, {u_value(0)}}, time, ""});
    Discretisation d;
    const auto failures = discretise(plan, d);
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_NE(std::string(failures[0].what()).find("outside the time interval"), std::string::npos);
  }
}

TEST(Probes, CombinationsReadOtherProbes) {
  auto plan = slab(4, 4);
  Probe ratio;
  ratio.name = "ratio";
  ratio.kind = Probe::Kind::combination;
  ratio.expression = var(slot::probe(0)) / var(slot::probe(1)) + var(slot::t);
  plan.report.probes.push_back(ratio);
  const auto result = solve(plan);
  EXPECT_DOUBLE_EQ(result.final.at("ratio"), result.final.at("u_y") / result.final.at("u_x") + 1.0);
}

/// A scalar that depends on one coordinate only: its slope along the other is zero, not an error.
TEST(Probes, ASlopeThatIsZeroIsNotMadeOfErrors) {
  for (const int along : {0, 1}) {
    Plan plan;
    plan.problem.mesh.cells = {7, 6, 1};
    const char* sides[][2] = {{"left", "right"}, {"bottom", "top"}};
    plan.problem.parts = {all_cells("plate"), group("low", sides[along][0]),
                          group("high", sides[along][1])};
    plan.problem.space.vector = false;
    plan.problem.space.dirichlet = {clamp(1), clamp(2, -1, {1.0})};
    plan.problem.forms = {diffusion(2, 0, field_of_u(0), 0.3)};
    const auto slope = [](int j) { return var(slot::field(field_of_u(0), slot::gradient(0, j))); };
    plan.report.probes = {at_point("x", slope(0), {0.45, 0.55, 0}),
                          at_point("y", slope(1), {0.45, 0.55, 0})};
    const auto result = solve(plan);
    EXPECT_NEAR(result.final.at(along == 0 ? "x" : "y"), 1.0, 1e-12);
    EXPECT_NEAR(result.final.at(along == 0 ? "y" : "x"), 0.0, 1e-12);
    for (const auto& column : result.forward_error.columns) {
      EXPECT_LT(column.relative, 1e-9);
      EXPECT_GT(column.relative, 0.0);
    }
  }
}

// Analytic: a bar that is moved as a whole has no strain; what rounding leaves of one is no error.
TEST(Probes, AStrainThatIsZeroIsNotMadeOfErrors) {
  auto plan = slab(4, 8);
  plan.problem.loads.clear();
  plan.problem.law_terms.clear();
  plan.problem.space.dirichlet = {clamp(flank, 0, {0.1 + var(slot::t) / 3}),
                                  clamp(flank, 1, {0.7})};
  plan.problem.time.initial = {0.1, 0.7};
  plan.report.probes.resize(3); // the last one reads the law
  plan.report.probes.push_back(
      integral("stretch", var(slot::field(field_of_u(0), slot::gradient(0, 0))), body));
  const auto result = solve(plan); // throws where it is not certified
  EXPECT_LT(std::abs(result.final.at("stretch")), 1e-12);
  for (const auto& column : result.forward_error.columns) {
    EXPECT_LT(column.absolute, 1e-12) << column.name;
    EXPECT_LT(column.relative, 1e-4) << column.name;
  }
}

/// A square of two triangles, turned by an angle, as a mesh file: the sides "top" and "ground".
void write_turned_square(const fs::path& path, double angle) {
  std::ofstream out(path);
  out.precision(17);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"top\"\n1 2 \"ground\"\n"
         "2 3 \"body\"\n$EndPhysicalNames\n$Nodes\n4\n";
  const double corners[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 4; ++i) {
    const auto [x, y] = corners[i];
    out << i + 1 << ' ' << std::cos(angle) * x - std::sin(angle) * y << ' '
        << std::sin(angle) * x + std::cos(angle) * y << " 0\n";
  }
  out << "$EndNodes\n$Elements\n4\n1 1 2 1 1 3 4\n2 1 2 2 2 1 2\n3 2 2 3 3 1 2 3\n"
         "4 2 2 3 3 1 3 4\n$EndElements\n";
}

// Analytic: a body that is held above and sticks below does not move; what rounding leaves of u is
// no error, though it is all there is of u.
TEST(Probes, ABodyThatSticksEverywhereIsNotMadeOfErrors) {
  const auto folder = fresh_folder("sticks");
  for (const double angle : {0.0, 0.3, 1.0, 2.2}) {
    write_turned_square(folder / "square.msh", angle);
    Plan plan;
    plan.problem.mesh.kind = MeshSpec::Kind::file;
    plan.problem.mesh.path = (folder / "square.msh").string();
    plan.problem.parts = {group("body", "body"), group("top", "top"), group("ground", "ground")};
    plan.problem.space.dirichlet = {clamp(1)};
    plan.problem.forms = {elastic(2, 0, field_of_u(0), from_young(70, 0.3))};
    plan.problem.laws = {slip_weakening()};
    plan.problem.law_terms = {tangential_term(0, 2, 2)};
    plan.problem.loads = {force(2, {0.1 * std::cos(angle), 0.1 * std::sin(angle)})};
    plan.report.probes = {norm("size")};
    const auto result = solve(plan);
    refuse_rounding(result, plan.problem);
    EXPECT_LT(result.final.at("size"), 1e-15) << angle; // the load alone would make it 1e-3
  }
}

// A probe without a name is a part of another one: nothing is said of it.
TEST(Probes, PartsHaveNoErrorOfTheirOwn) {
  auto plan = slab(4, 4);
  Probe part = plan.report.probes[0], whole;
  part.name = "";
  whole.name = "whole";
  whole.kind = Probe::Kind::combination;
  whole.expression = -var(slot::probe(static_cast<int>(plan.report.probes.size())));
  plan.report.probes.push_back(part);
  plan.report.probes.push_back(whole);
  const auto columns = solve(plan).forward_error.columns;
  ASSERT_EQ(columns.size(), plan.report.probes.size() - 1);
  EXPECT_EQ(columns.back().name, "whole");
  EXPECT_DOUBLE_EQ(columns.back().absolute, columns.front().absolute);
}

// Analytic: the multiplier at a node of the contact part is the slope there; the factor before a
// law scales its force, not its multiplier.
TEST(Probes, MultipliersAtNodesAndUnderAFactor) {
  auto plan = slab(4, 4);
  plan.problem.law_terms[0].factor = 0.5;
  plan.problem.laws[0].expression = 8.0 * max(var(slot::argument(0)), 0.0);
  plan.report.probes = {at_point("xi", var(slot::multiplier(0, 0)), {1, 0, 0}),
                        at_point("u_y", u_value(1), {1, 0, 0}),
                        integral("p", var(slot::multiplier(0, 0)), ground),
                        integral("work", var(slot::multiplier(0, 0)) * u_value(1), ground)};
  const auto result = solve(plan);
  expect_relative(result.final.at("xi"), -8.0 * result.final.at("u_y"), 1e-12, "xi");
  auto plain = plan;
  plain.problem.law_terms[0].factor = 1.0;
  plain.problem.laws[0].expression = 4.0 * max(var(slot::argument(0)), 0.0);
  const auto same = solve(plain);
  expect_relative(result.final.at("p"), 2 * same.final.at("p"), 1e-11, "p");
  expect_relative(result.final.at("work"), 2 * same.final.at("work"), 1e-11, "work");
}

// A load that lifts the slab off: the law never acts, costs no iteration and is reported asleep.
TEST(Effects, ALawThatNeverActsIsAsleep) {
  auto plan = slab(4, 8);
  plan.problem.loads = {force(body, {0.0, 10.0 * var(slot::t)})};
  plan.problem.effects = {
      {"normal law", EffectNote::State::on, plan.problem.law_terms[0].origin, ""}};
  const auto result = solve(plan);
  EXPECT_EQ(result.effects[0].state, EffectNote::State::asleep);
  EXPECT_EQ(result.work.newton, 0);
}

std::string why_of(const RunResult& result, const std::string& name) {
  for (const auto& effect : result.effects)
    if (effect.name == name) return effect.why;
  ADD_FAILURE() << "no effect " << name;
  return {};
}

// A spring on both sides is a line through zero wherever it is reached; one that acts on one side
// only is not, once points have left it.
TEST(Effects, ALawIsLinearWhereOnlyOneOfItsPiecesIsReached) {
  auto plan = slab(4, 8);
  plan.problem.effects = {{"law", EffectNote::State::on, plan.problem.law_terms[0].origin, ""}};
  plan.problem.laws[0].expression = 4.0 * var(slot::argument(0));
  EXPECT_EQ(why_of(solve(plan), "law"), "linear on the range reached: 4 times its argument");
  plan.problem.laws[0].expression = 4.0 * max(var(slot::argument(0)), 0.0);
  EXPECT_EQ(why_of(solve(plan), "law"), "linear on the range reached: 4 times its argument");
  plan.problem.loads = {force(body, {0.0, -10.0 * sin(7.0 * var(slot::t))})}; // down, then up
  EXPECT_EQ(why_of(solve(plan), "law"), "");
}

TEST(Effects, LoadsDimensionsAndSymmetryAreSaid) {
  auto plan = slab(4, 4);
  const Expr t = var(slot::t), x = var(slot::x(0));
  const auto said = [&](const Expr& pull) {
    plan.problem.loads = {force(ground, {0.0, t}), force(body, {0.0, pull})};
    plan.problem.loads[1].origin = {77};
    return why_of(solve(plan), "load on `" + plan.problem.parts[body].name + "`");
  };
  EXPECT_EQ(said(-10.0 * x), "the same at all times: assembled once");
  EXPECT_EQ(said(-10.0 * t * x), "separable in time: assembled once for each function of time");
  EXPECT_EQ(said(-1.0 / (1.0 + t * x)), "not separable in time: assembled at every step");
  const auto result = solve(plan);
  EXPECT_EQ(why_of(result, "space dimension y"), "");
  EXPECT_EQ(why_of(result, "space dimension z"), "the mesh has 2 dimensions");
  EXPECT_EQ(why_of(result, "symmetry"),
            "all matrices are symmetric: one triangle is factored (Cholesky)");
}

// Forms that cost nothing: equal tensors under other names, split parts, zero entries.
TEST(Effects, ProportionalFormsShareMatrices) {
  auto plan = slab(4, 4);
  EXPECT_EQ(solve(plan).work.matrices, 2);
  plan.problem.forms[0] = elastic(2, body, field_of_u(1), from_young(35, 0.3)); // viscosity = B / 2
  EXPECT_EQ(solve(plan).work.matrices, 1);
  // The same numbers through expressions that only values reveal.
  plan.problem.forms[0] = elastic(2, body, field_of_u(1), {1, 1});
  const auto b = from_young(35, 0.3);
  for (std::size_t e = 0; e < plan.problem.forms[0].entries.size(); ++e)
    plan.problem.forms[0].entries[e].coefficient =
        (e % 3 == 0 ? b.lambda : b.mu) + 0.0 * var(slot::x(0)) + max(-1.0 - var(slot::x(0)), 0.0);
  EXPECT_EQ(solve(plan).work.matrices, 1);
}

} // namespace
} // namespace hvi::solver
