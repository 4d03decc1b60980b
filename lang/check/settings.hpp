// The settings of a find statement: `with scheme = bdf2, tolerance = 1e-10`.
#pragma once

#include "lang/check/context.hpp"

#include <string>
#include <utility>
#include <vector>

namespace hvi::lang {

class Settings {
public:
  explicit Settings(const Context& context)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns),
        evaluator_(context.evaluator) {}

  void read(const ast::Find& find);

private:
  void set_scheme(const ast::Setting& setting);
  void set_hht_alpha(const ast::Setting& setting);
  template <class T>
  void choose(const ast::Setting& setting, const std::string& what,
              const std::vector<std::pair<std::string, T>>& choices, T& out);
  void set_threads(const ast::Setting& setting);
  void set_positive(const ast::Setting& setting, double& out);
  void set_tolerance(const ast::Setting& setting, double& out);
  void set_quadrature(const ast::Setting& setting);
  void set_accuracy_of(const ast::Setting& setting);
  void check_accuracy_of(const ast::Find& find);
  void setting(const ast::Setting& setting);

  Mistakes& mistakes_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
};

} // namespace hvi::lang
