// See objects.hpp.
#include "lang/python/objects.hpp"

#include <algorithm>
#include <sstream>

namespace hvi::python {

namespace py = pybind11;
using Json = nlohmann::ordered_json;

py::array_t<double> to_numpy(const Array& array) {
  py::array_t<double> out(std::vector<py::ssize_t>(array.shape.begin(), array.shape.end()));
  std::ranges::copy(array.values, out.mutable_data());
  return out;
}

py::dict to_dict(const std::vector<Array>& arrays) {
  py::dict out;
  for (const Array& array : arrays) out[py::str(array.name)] = to_numpy(array);
  return out;
}

py::dict to_dict(const Grid& grid) {
  const auto each = std::max<std::int64_t>(grid.nodes_per_cell, 1);
  const auto count = static_cast<std::int64_t>(grid.cells.size()) / each;
  py::array_t<std::int64_t> cells(std::vector<py::ssize_t>{count, each});
  std::ranges::copy(grid.cells, cells.mutable_data());
  py::dict out;
  out["points"] = to_numpy(grid.points), out["cells"] = cells, out["cell_type"] = grid.cell;
  return out;
}

py::object to_python(const Json& value) {
  switch (value.type()) {
  case Json::value_t::object: {
    py::dict out;
    for (const auto& [key, member] : value.items()) out[py::str(key)] = to_python(member);
    return out;
  }
  case Json::value_t::array: {
    py::list out;
    for (const auto& member : value) out.append(to_python(member));
    return out;
  }
  case Json::value_t::string:
    return py::str(value.get_ref<const std::string&>());
  case Json::value_t::boolean:
    return py::bool_(value.get<bool>());
  case Json::value_t::number_integer:
  case Json::value_t::number_unsigned:
    return py::int_(value.get<std::int64_t>());
  case Json::value_t::number_float:
    return py::float_(value.get<double>());
  default:
    return py::none();
  }
}

py::dict to_dict(const Answer& answer) {
  py::dict out;
  py::list diagnostics;
  std::istringstream lines(answer.diagnostics);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) diagnostics.append(to_python(Json::parse(line)));
  out["exit"] = static_cast<int>(answer.exit);
  out["diagnostics"] = diagnostics, out["text"] = answer.text;
  out["data"] = to_python(answer.data);
  out["table"] = to_dict(answer.table), out["fields"] = to_dict(answer.fields);
  out["monitors"] = to_dict(answer.monitors);
  out["kept_times"] =
      to_numpy({"t", {static_cast<std::int64_t>(answer.kept_times.size())}, answer.kept_times});
  out["kept"] = to_dict(answer.kept);
  if (answer.grid) out["grid"] = to_dict(*answer.grid);
  return out;
}

} // namespace hvi::python
