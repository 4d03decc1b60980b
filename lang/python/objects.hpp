// Answers as objects of Python.
#pragma once

#include "lang/python/answer.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace hvi::python {

pybind11::array_t<double> to_numpy(const Array& array);
pybind11::dict to_dict(const std::vector<Array>& arrays);
pybind11::dict to_dict(const Grid& grid);
pybind11::object to_python(const nlohmann::ordered_json& value);
/// exit, diagnostics (a list of dictionaries), text, data, table, fields, monitors, kept, grid
pybind11::dict to_dict(const Answer& answer);

} // namespace hvi::python
