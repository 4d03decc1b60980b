// What a command of the library found out, before it becomes objects of Python.
#pragma once

#include "lang/session.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace hvi::python {

/// Numbers with a shape, the last index fastest.
struct Array {
  std::string name;
  std::vector<std::int64_t> shape;
  std::vector<double> values;
};

/// Nodes of the space, with its cells in VTK's order of nodes.
struct Grid {
  std::string cell; ///< "triangle6", as meshio calls it
  Array points;
  std::int64_t nodes_per_cell = 0;
  std::vector<std::int64_t> cells;
};

struct Answer {
  lang::Exit exit = lang::exit_ok;
  std::string diagnostics; ///< a JSON object a line (render.hpp)
  std::string text;        ///< the same for people
  nlohmann::ordered_json data;
  std::vector<Array> table, fields, monitors; ///< columns; values at the nodes at the end; energies
  std::vector<double> kept_times;
  std::vector<Array> kept; ///< of each unknown: steps x nodes (x components)
  std::optional<Grid> grid;
};

/// Adds what the session has to say.
void add_diagnostics(const lang::Session& session, Answer& answer);

} // namespace hvi::python
