// The facts about each operation that are not formulas: its name and its number of arguments.
#include "solver/kernel/node.hpp"

namespace hvi::solver {

namespace {

struct Facts {
  std::string_view name;
  int arity;
};

/// One line per operation; a switch, so that the compiler finds a forgotten one.
Facts facts(Op op) {
  switch (op) {
  case Op::constant:
    return {"constant", -1};
  case Op::slot:
    return {"slot", -1};
  case Op::add:
    return {"add", 2};
  case Op::mul:
    return {"mul", 2};
  case Op::div:
    return {"div", 2};
  case Op::neg:
    return {"neg", 1};
  case Op::pow:
    return {"pow", 2};
  case Op::min:
    return {"min", 2};
  case Op::max:
    return {"max", 2};
  case Op::abs:
    return {"abs", 1};
  case Op::sign:
    return {"sign", 1};
  case Op::exp:
    return {"exp", 1};
  case Op::log:
    return {"log", 1};
  case Op::sqrt:
    return {"sqrt", 1};
  case Op::sin:
    return {"sin", 1};
  case Op::cos:
    return {"cos", 1};
  case Op::tan:
    return {"tan", 1};
  case Op::asin:
    return {"asin", 1};
  case Op::acos:
    return {"acos", 1};
  case Op::atan:
    return {"atan", 1};
  case Op::atan2:
    return {"atan2", 2};
  case Op::sinh:
    return {"sinh", 1};
  case Op::cosh:
    return {"cosh", 1};
  case Op::tanh:
    return {"tanh", 1};
  case Op::erf:
    return {"erf", 1};
  case Op::erfc:
    return {"erfc", 1};
  case Op::gamma:
    return {"gamma", 1};
  case Op::bessel_j:
    return {"bessel_j", 2};
  case Op::erfcx:
    return {"erfcx", 2};
  case Op::mittag_leffler:
    return {"mittag_leffler", 3};
  case Op::less:
    return {"less", 2};
  case Op::less_equal:
    return {"less_equal", 2};
  case Op::equal:
    return {"equal", 2};
  case Op::logic_and:
    return {"and", 2};
  case Op::logic_or:
    return {"or", 2};
  case Op::logic_not:
    return {"not", 1};
  case Op::select:
    return {"select", 3};
  case Op::table:
    return {"table", 1};
  case Op::table_slope:
    return {"table_slope", 1};
  case Op::polygamma:
    return {"polygamma", 2};
  }
  return {"?", -1};
}

} // namespace

std::string_view op_name(Op op) { return facts(op).name; }
int arity(Op op) { return facts(op).arity; }

} // namespace hvi::solver
