// What the tests of the checker and of the lowering share: scripts and their models.
#pragma once

#include "lang/check/check.hpp"
#include "lang/syntax/parser.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace hvi::lang::testing_scripts {

struct Checked {
  std::optional<Model> model;
  std::vector<std::string> errors; ///< their codes, in the order of the script
  std::vector<std::string> helps;  ///< what each of them proposes
  std::vector<std::string> messages;
  std::vector<std::string> beside; ///< the other places they tell: "called here: pull(3)"
};

inline Checked checked(const std::string& text, std::map<std::string, std::string> defines = {}) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", text);
  const std::vector<ast::Program> programs{parse(source, diagnostics)};
  CheckOptions options;
  options.defines = std::move(defines);
  Checked out{check(programs, options, diagnostics), {}, {}, {}, {}};
  for (const auto& d : diagnostics.sorted()) {
    if (d.severity != Severity::error) continue;
    out.errors.push_back(d.code), out.helps.push_back(d.help);
    out.messages.push_back(d.message);
    for (const auto& label : d.secondary)
      out.beside.push_back(label.text + ": " + std::string(source.text(label.span)));
  }
  return out;
}

/// A static problem in 2D or 3D with these declarations, left side and right side.
inline std::string problem(int dim, const std::string& declarations, const std::string& left,
                           const std::string& right) {
  const std::string mesh =
      dim == 2 ? "rectangle(2, 1, cells = [2, 1])" : "box(2, 1, 1, cells = [2, 1, 1])";
  return "mesh body = " + mesh + "\npart ground = body.bottom\npart roof = body.top\n" +
         declarations +
         "space V = vector P1 on body, zero on roof\nfind u in V\nsuch that for all v in V\n    " +
         left + "\n  = " + right + "\n";
}

/// Numbers for slots, drawn once for each and kept.
class Values {
public:
  explicit Values(std::mt19937& random) : random_(random) {}
  double operator()(solver::Slot slot) {
    const auto [at, fresh] = drawn_.try_emplace(slot, 0.0);
    if (fresh) at->second = std::uniform_real_distribution(-1.0, 1.0)(random_);
    return at->second;
  }
  double of(const Symbol& e) { return evaluate(e, std::ref(*this)); }
  /// sym grad of the function with these slots, d x d.
  double strain(const std::function<solver::Slot(int)>& slot_of, int i, int j) {
    return 0.5 * ((*this)(slot_of(solver::slot::gradient(i, j))) +
                  (*this)(slot_of(solver::slot::gradient(j, i))));
  }
  double strain_of_u(int i, int j) {
    return strain([](int d) { return solver::slot::field(solver::field_of_u(0), d); }, i, j);
  }
  double strain_of_v(int i, int j) {
    return strain([](int d) { return solver::slot::test(d); }, i, j);
  }

private:
  std::mt19937& random_;
  std::map<solver::Slot, double> drawn_;
};

/// Between low and high, with three digits, so that script and test have the same number.
inline double drawn(std::mt19937& random, double low, double high) {
  return std::round(1e3 * std::uniform_real_distribution(low, high)(random)) / 1e3;
}

} // namespace hvi::lang::testing_scripts
